//! What a frame costs does not grow unnoticed.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use host_tools::bench::rows::{Group, ROWS};
use host_tools::bench::{Ready, Subject, committed};
use host_tools::machine::Machine;
use host_tools::model::Up;
use host_tools::view::{StandardView, View};
use rho_tests::firmware::{target_dir, workspace};

/// What a figure may grow by without the page being made again, in per cent.
const TOLERANCE: u64 = 2;

#[test]
fn no_figure_of_ours_is_larger_than_in_the_committed_table() {
    let page = workspace().join("docs/bench.md");
    let committed = committed(&fs::read_to_string(&page).unwrap());
    let bunny = Subject::scan("bunny", Up::Y).unwrap_or_else(|failure| panic!("{failure}"));
    let mut grown = String::new();
    let mut check = |name: &str, of: &str, now: u64| {
        let then = committed.get(&(name.to_owned(), of.to_owned()));
        match then {
            None => writeln!(grown, "{name}, {of}: {now}, and not in the table"),
            Some(then) if 100 * now > (100 + TOLERANCE) * then => {
                let more = 100.0 * (now as f64 / *then as f64 - 1.0);
                writeln!(grown, "{name}, {of}: {now}, {more:.1} % more than {then}")
            }
            Some(_) => Ok(()),
        }
        .unwrap();
    };
    for row in ROWS.into_iter().filter(|row| row.group == Group::Ours) {
        let folder: &Path = workspace();
        let ready = Ready::new(row, Machine::M3, &bunny, folder, Some(&target_dir())).unwrap();
        check(row.name, "all views", ready.model_bytes() as u64);
        for view in StandardView::ALL {
            let run = ready.draw(&View::from(view), None).unwrap();
            check(row.name, view.name(), run.report.phases.frame());
        }
    }
    assert!(
        grown.is_empty(),
        "docs/bench.md tells other figures (instructions; bytes for all views):\n{grown}\
         If that is meant, run `make bench`, look at the difference and commit the page."
    );
}
