//! What one cell holds of a surface, summed up.
//!
//! A disc stands for all the surface in its cell, so it is placed by area: mean normal and centre of
//! gravity, not those of one point. Sums of area, first moment and normal add up: a cell's are
//! those of its subcells, and where the mean over a wider part is wanted its neighbours' are
//! added.

use glam::Vec3;

use super::Sample;
use super::cells::Cell;

/// Part of a surface, in the units of one cell: lengths in its sides, from its centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Portion {
    /// Area in faces of the cell.
    pub area: f32,
    /// The centre of gravity times `area`.
    pub moment: Vec3,
    /// The mean of the unit normals times `area`: the shorter the more they differ.
    pub normal: Vec3,
    /// The area of the largest piece.
    pub largest: f32,
    /// sRGB, that of the largest piece.
    pub colour: [u8; 3],
    /// The mean of the colours times `area`.
    pub tint: Vec3,
    /// Whether some of the surface faces the other way.
    pub two_sided: bool,
}

impl Portion {
    /// The surface round one point of it, as far as `area` faces of the cell.
    #[must_use]
    pub fn at(sample: &Sample, cell: &Cell, area: f32) -> Self {
        Self {
            area,
            moment: area * ((sample.position - cell.centre()) / cell.side()).as_vec3(),
            normal: area * sample.normal.as_vec3(),
            largest: area,
            colour: sample.colour,
            tint: area * Vec3::from_array(sample.colour.map(f32::from)),
            two_sided: false,
        }
    }

    /// A piece with `area` in squares of the cube's side.
    #[must_use]
    pub fn piece(sample: &Sample, cell: &Cell, area: f64) -> Self {
        Self::at(sample, cell, (area / (cell.side() * cell.side())) as f32)
    }

    /// Both; the first's colour when their largest pieces are equal.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let (largest, colour) = if other.largest > self.largest {
            (other.largest, other.colour)
        } else {
            (self.largest, self.colour)
        };
        Self {
            area: self.area + other.area,
            moment: self.moment + other.moment,
            normal: self.normal + other.normal,
            largest,
            colour,
            tint: self.tint + other.tint,
            two_sided: self.two_sided,
        }
    }

    /// Counted `weight` times.
    #[must_use]
    pub fn weighted(self, weight: f32) -> Self {
        Self {
            area: weight * self.area,
            moment: weight * self.moment,
            normal: weight * self.normal,
            largest: weight * self.largest,
            tint: weight * self.tint,
            ..self
        }
    }

    /// As seen from a cell of the same size, from whose centre this one's is `by` sides away.
    #[must_use]
    pub fn moved(self, by: Vec3) -> Self {
        Self {
            moment: self.moment + self.area * by,
            ..self
        }
    }

    /// In the units of a cell `rho` times as large with the same centre.
    #[must_use]
    pub fn shrunk(self, rho: f32) -> Self {
        let faces = self.weighted(1.0 / (rho * rho));
        Self {
            moment: faces.moment / rho,
            ..faces
        }
    }

    /// Whether so much of it faces another way that the mean tells nothing: two sheets, the
    /// edge of a blade. (At the corner of a box three faces still agree to 0.58.)
    fn folds(&self) -> bool {
        self.normal.length() < 0.5 * self.area
    }

    fn distance(&self) -> f32 {
        self.moment.length() / self.area
    }

    /// All parts together, or, where they fold, those that face as the one nearest the
    /// cell's centre does. Parts have an area.
    pub fn sum(parts: impl Iterator<Item = Self> + Clone) -> Self {
        /// Of the area, from which on what faces the other way counts.
        const OPPOSED: f32 = 0.1;
        let whole = parts.clone().fold(Self::default(), Self::with);
        let opposed = parts
            .clone()
            .filter(|part| part.normal.dot(whole.normal) < 0.0);
        let opposed: f32 = opposed.map(|part| part.area).sum();
        let two_sided = opposed > OPPOSED * whole.area || parts.clone().any(|part| part.two_sided);
        if !whole.folds() {
            return Self { two_sided, ..whole };
        }
        let nearest = parts
            .clone()
            .min_by(|a, b| a.distance().total_cmp(&b.distance()))
            .unwrap_or_default();
        let facing = parts
            .filter(|part| part.normal.dot(nearest.normal) > 0.0)
            .fold(Self::default(), Self::with);
        Self {
            two_sided: true,
            ..facing
        }
    }
}

/// The portion that pieces of a surface make up in `cell`: each with its area in squares of the
/// cube's side and the sample at its centre of gravity. Where that is next to nothing, as of a
/// surface that only touches the cell, `nearest` speaks, the point nearest the cell's centre.
pub fn gather(
    cell: &Cell,
    pieces: impl Iterator<Item = (f64, Sample)>,
    nearest: impl FnOnce() -> Option<Sample>,
) -> Option<Portion> {
    /// In faces of the cell.
    const NOTHING: f32 = 1e-6;
    let pieces: Vec<Portion> = pieces
        .map(|(area, sample)| Portion::piece(&sample, cell, area))
        .filter(|piece| piece.area > 0.0)
        .collect();
    let portion = Portion::sum(pieces.into_iter());
    if portion.area > NOTHING {
        Some(portion)
    } else {
        Some(Portion::at(&nearest()?, cell, NOTHING))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::WHITE;
    use super::*;

    fn part(area: f32, at: Vec3, normal: Vec3) -> Portion {
        Portion {
            area,
            moment: area * at,
            normal: area * normal,
            largest: area,
            colour: WHITE,
            tint: area * Vec3::splat(255.0),
            two_sided: false,
        }
    }

    #[test]
    fn sums_do_not_depend_on_where_they_are_taken_from() {
        let there = part(0.5, Vec3::new(0.1, -0.2, 0.3), Vec3::Z);
        let seen = there.moved(Vec3::X).shrunk(3.0);
        assert_eq!(seen.area, 0.5 / 9.0);
        let centre = seen.moment / seen.area;
        assert!((centre - Vec3::new(1.1, -0.2, 0.3) / 3.0).length() < 1e-6);
        assert!((seen.normal / seen.area - Vec3::Z).length() < 1e-6);
    }

    #[test]
    fn of_two_sheets_the_nearer_speaks() {
        let near = part(0.5, 0.1 * Vec3::Y, Vec3::Y);
        let far = part(0.6, -0.4 * Vec3::Y, -Vec3::Y);
        let near = Portion {
            two_sided: true,
            ..near
        };
        assert_eq!(Portion::sum([far, near].into_iter()), near);
        assert_eq!(Portion::sum([near, far].into_iter()), near);
    }

    #[test]
    fn an_edge_is_the_mean_of_its_sides() {
        let sides = [part(1.0, Vec3::X, Vec3::X), part(1.0, Vec3::Y, Vec3::Y)];
        let both = Portion::sum(sides.into_iter());
        assert_eq!(both.area, 2.0);
        assert_eq!(both.normal, Vec3::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn the_largest_piece_gives_the_colour() {
        let coloured = |area, colour| Portion {
            colour,
            ..part(area, Vec3::ZERO, Vec3::Y)
        };
        let parts = [
            coloured(0.1, [1; 3]),
            coloured(0.3, [2; 3]),
            coloured(0.2, [3; 3]),
        ];
        assert_eq!(Portion::sum(parts.into_iter()).colour, [2; 3]);
    }

    #[test]
    fn where_the_surface_only_touches_the_cell_its_nearest_point_speaks_softly() {
        let nearest = Sample {
            position: DVec3::new(0.5, 0.1, 0.0),
            normal: DVec3::X,
            colour: WHITE,
        };
        let portion = gather(&Cell::ROOT, std::iter::empty(), || Some(nearest)).unwrap();
        assert!(portion.area > 0.0 && portion.area < 1e-5);
        assert!((portion.moment / portion.area - Vec3::new(0.5, 0.1, 0.0)).length() < 1e-6);
        assert_eq!(gather(&Cell::ROOT, std::iter::empty(), || None), None);
    }
}
