//! One level of the mesh while it is textured.

use nalgebra::{Point3, Vector3};

use crate::neighborhood::{Place, Spots, Stencil};

use super::canvas::CanvasLevel;
use super::descriptors::{Layer, Reader};
use super::params::Method;
use super::sites::{Sharpness, Sites};

/// Radii of a neighborhood in texels: on its own level, and on the next coarser one, in texels of that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) own: usize,
    pub(super) coarse: Option<usize>,
}

impl Window {
    /// Of a level, 0 the finest, of so many.
    ///
    /// The paper's are {1×1, 1}, {3×3, 2}, {5×5, 2}, {7×7, 2} from the coarsest of four levels on, and half as wide on the
    /// coarser one; the other method's are {7×7, 2} throughout.
    pub(super) fn of_level(level: usize, levels: usize, method: Method) -> Self {
        let is_coarsest = level + 1 == levels;
        let own = match method {
            Method::Coherent => 3,
            Method::WeiLevoy => 3usize.saturating_sub(level).max(usize::from(!is_coarsest)),
        };
        Self {
            own,
            coarse: (!is_coarsest).then(|| own.div_ceil(2)),
        }
    }
}

/// Where the offsets of a window lie, for every vertex of the mesh.
#[derive(Debug)]
pub(super) struct Looks {
    pub(super) own: Spots,
    pub(super) coarse: Option<Spots>,
}

impl Looks {
    /// By walking along the surface, or by the paper's method flattened. `above`: the next coarser level, and where the
    /// vertices are on it.
    pub(super) fn new(
        level: &CanvasLevel,
        above: Option<(&CanvasLevel, &[Option<Place>])>,
        window: &Window,
        method: Method,
    ) -> Self {
        let lay = |on: &CanvasLevel, radius: usize, places: &[Option<Place>]| {
            let stencil = Stencil::square(radius, on.texel);
            match method {
                Method::Coherent => Spots::walked(&on.surface, &stencil, places),
                Method::WeiLevoy => Spots::flattened(&on.surface, &stencil, places, &level.normals),
            }
        };
        Self {
            own: lay(level, window.own, &level.places),
            coarse: (window.coarse.zip(above))
                .map(|(radius, (above, places))| lay(above, radius, places)),
        }
    }

    pub(super) fn sharpness(&self) -> Sharpness {
        Sharpness {
            own: self.own.sharpness(),
            coarse: self.coarse.as_ref().map(Spots::sharpness),
        }
    }
}

/// A level of the mesh, what may be copied to it, and the coarser level that is done.
#[derive(Debug, Clone, Copy)]
pub(super) struct Work<'a> {
    pub(super) canvas: &'a CanvasLevel,
    pub(super) sites: &'a Sites<'a>,
    pub(super) looks: &'a Looks,
    pub(super) above: Option<Above<'a>>,
}

/// The next coarser level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Above<'a> {
    pub(super) canvas: &'a CanvasLevel,
    pub(super) painted: &'a Painted,
    /// Where the vertices of the finer level are on it.
    pub(super) places: &'a [Option<Place>],
}

impl<'a> Work<'a> {
    /// What neighborhoods are read from, as things stand.
    pub(super) fn reader(&self, painted: &'a Painted) -> Reader<'a> {
        Reader {
            coarse: (self.looks.coarse.as_ref().zip(self.above)).map(|(spots, above)| Layer {
                spots,
                values: &above.painted.values,
            }),
            own: Layer {
                spots: &self.looks.own,
                values: &painted.values,
            },
            unknown: &self.sites.mean,
        }
    }

    /// A site as a place on the sample.
    pub(super) fn place(&self, site: u32) -> Place {
        let vertex = self.sites.vertices[site as usize];
        self.sites.level.places[vertex as usize].expect("sites are on the surface")
    }

    /// From the source of vertex `from` to where it continues at vertex `to`; `None` beyond the sample's border.
    pub(super) fn continued(&self, painted: &Painted, from: usize, to: usize) -> Option<Place> {
        let positions = self.canvas.surface.positions();
        let offset = self.canvas.flat(from, &(positions[to] - positions[from]));
        let scale = self.sites.level.texel / self.canvas.texel;
        let source = &painted.sources[from];
        self.sites.level.surface.walk(source, scaled(offset, scale))
    }

    /// Number of vertices.
    pub(super) fn len(&self) -> u32 {
        u32::try_from(self.canvas.normals.len()).expect("vertices are u32")
    }
}

/// An offset in another unit.
#[expect(clippy::cast_possible_truncation, reason = "offsets are single")]
pub(super) fn scaled(offset: [f64; 2], scale: f64) -> [f32; 2] {
    offset.map(|x| (x * scale) as f32)
}

/// What stands on a level of the mesh.
#[derive(Debug, Clone)]
pub(super) struct Painted {
    /// #V: where on the sample's level each vertex was copied from.
    pub(super) sources: Vec<Place>,
    /// #V by C.
    pub(super) values: Vec<f32>,
    /// #V: what the match cost, a mean of squared differences; NaN of those that were not matched.
    pub(super) costs: Vec<f32>,
}

impl Painted {
    /// Copies what is at `source` to a vertex.
    pub(super) fn set(&mut self, v: u32, source: Place, sites: &Sites, cost: f32) {
        let values = sites.values(sites.level.nearest(&source));
        let v = v as usize;
        self.sources[v] = source;
        self.values[v * values.len()..][..values.len()].copy_from_slice(values);
        self.costs[v] = cost;
    }
}

impl CanvasLevel {
    /// Components of a vector along the two tangents of a vertex, stretched to the length that it has in space.
    fn flat(&self, v: usize, vector: &Vector3<f64>) -> [f64; 2] {
        let x = &self.directions[v];
        let y = self.normals[v].cross(x);
        let [a, b] = [vector.dot(x), vector.dot(&y)];
        let length = a.hypot(b);
        let stretch = if length > 0.0 {
            vector.norm() / length
        } else {
            0.0
        };
        [a * stretch, b * stretch]
    }

    /// The same from a vertex to a point.
    pub(super) fn offset_to(&self, v: usize, point: &Point3<f64>) -> [f64; 2] {
        self.flat(v, &(point - self.surface.positions()[v]))
    }
}
