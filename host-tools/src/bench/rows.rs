//! What is measured: the rows of the table.

use crate::cargo::Package;
use crate::machine::Machine;

/// A way to draw a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Its name in the table.
    pub name: &'static str,
    /// Whose it is.
    pub group: Group,
    /// How it draws.
    pub way: Way,
}

/// Whose a way is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// This project's; its figures may not grow.
    Ours,
    /// The paper's, by this project's parts.
    Paper,
    /// Somebody else's.
    Peer,
}

/// How a model is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// By the renderer.
    Renderer {
        /// Flags of `rho bake`.
        bake: &'static str,
        /// Flags of `rho run`.
        run: &'static str,
    },
    /// By a program of the package `rho-peers`, from every vertex.
    Points(&'static str),
    /// By a program of the package `rho-peers`, from at most so many triangles.
    Triangles(&'static str, usize),
}

const fn ours(name: &'static str, bake: &'static str, run: &'static str) -> Row {
    let (group, way) = (Group::Ours, Way::Renderer { bake, run });
    Row { name, group, way }
}

const fn paper(name: &'static str, bake: &'static str, run: &'static str) -> Row {
    let (group, way) = (Group::Paper, Way::Renderer { bake, run });
    Row { name, group, way }
}

const fn peer(name: &'static str, way: Way) -> Row {
    let group = Group::Peer;
    Row { name, group, way }
}

/// One grid of 243 cells with every intermediate sample, as the paper's.
const GRID_243: &str = "--rho 3 --subdivisions 5";

/// All rows, in the order of the table.
pub const ROWS: [Row; 10] = [
    ours("fast", "", "--preset fast"),
    ours("balanced", "", "--preset balanced"),
    ours("fine", "", "--preset fine"),
    ours("finest", "", "--preset finest"),
    ours("boxes, 243 cells", GRID_243, "--footprint box"),
    // Section 5.1: every leaf, a pixel each, against a depth buffer.
    paper(
        "paper: points",
        GRID_243,
        "--visibility z --footprint point --cell-size 0",
    ),
    // Section 5.2: a cell below a pixel is drawn from its own sample, a splat as large as it.
    paper(
        "paper: multi-level splats",
        GRID_243,
        "--visibility z --footprint splat --cell-size 1",
    ),
    peer("flat points, 2x2 dots", Way::Points("flat-points")),
    peer(
        "embedded-3dgfx, 5,000 triangles",
        Way::Triangles("triangles-5k", 5_000),
    ),
    peer(
        "embedded-3dgfx, all triangles",
        Way::Triangles("triangles", usize::MAX),
    ),
];

impl Row {
    /// The same with a model baked otherwise; a peer's model is not baked.
    #[must_use]
    pub fn baked(&self, bake: &'static str) -> Self {
        match self.way {
            Way::Renderer { run, .. } => Self {
                way: Way::Renderer { bake, run },
                ..*self
            },
            Way::Points(_) | Way::Triangles(..) => *self,
        }
    }
}

impl Way {
    /// The program that draws on a machine.
    #[must_use]
    pub fn package(&self, machine: Machine) -> Package<'static> {
        match *self {
            Self::Renderer { .. } => machine.viewer(),
            Self::Points(program) | Self::Triangles(program, _) => Package {
                name: "rho-peers",
                program: Some(program),
                ..machine.viewer()
            },
        }
    }
}
