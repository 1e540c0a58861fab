//! Duguet & Drettakis 2003 again: the paper's tables beside what this project measures.
//!
//! ```text
//! models     the paper's models, and what stands in for them here
//! memory     tables 1 and 4: bytes            from blobs that `rho bake` makes
//! operations table 2: operations a sample     instructions of the device
//! normals    table 3: the error of normals    of lighting, too
//! ram        what a mode keeps in memory
//! rendering  table 5 and the figures          instructions and pictures of the device
//! ```

pub mod memory;
pub mod models;
pub mod normals;
pub mod operations;
pub mod ram;
pub mod rendering;

/// A table in Markdown: the first column is text, the others are numbers.
#[must_use]
pub fn table(columns: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let cells: Vec<_> = cells.collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let ruler = columns
        .iter()
        .enumerate()
        .map(|(column, _)| if column == 0 { "---" } else { "---:" });
    let mut table = line(&mut columns.iter().copied());
    table += &line(&mut { ruler });
    for row in rows {
        table += &line(&mut row.iter().map(String::as_str));
    }
    table
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_table_has_a_ruler_and_its_numbers_to_the_right() {
        let rows = [vec!["a".to_owned(), "1".to_owned()]];
        let table = super::table(&["what", "how many"], &rows);
        assert_eq!(table, "| what | how many |\n| --- | ---: |\n| a | 1 |\n");
    }
}
