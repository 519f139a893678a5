//! k-cuts: half-splitting with up to seven planes across the view's dominant axis, placed where they pay.
//!
//! What a plane saves is known exactly for rays along the axis, one per column of blocks. Such a ray marches the active
//! layers of its column and the gaps between them, except those that a plane cuts. So the length of every slab follows
//! from two counts, of active blocks by layer and of gaps by both ends, and dynamic programming over the layers places
//! the planes: reading the occupancy once, then `slabs * layers^2` additions.

use std::ops::Range;

use super::Skip;
use super::plan::Listed;
use super::traversal::Line;
use crate::octree::Occupancy;

/// The most slabs that the volume is cut into.
pub const MAX_SLABS: usize = 8;

/// What a cut costs, in samples on every pixel of the box: clearing and drawing two more layers of depth and reading
/// them in the marcher. An estimate, where nothing is calibrated: in the reference, and while calibration itself draws.
pub const CUT_SAMPLES: f64 = 4.0;

/// [`CUT_SAMPLES`] in block lengths per column, for half-voxel steps and 8-voxel blocks.
pub const DEFAULT_CUT_COST: f64 = CUT_SAMPLES / 16.0;

/// Where the methods that cut do so.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Cuts {
    /// The plane of half-split.
    pub half: HalfCut,
    /// The planes of k-cuts.
    pub slabs: SlabCount,
}

impl Cuts {
    /// Where `skip` cuts across an axis whose middle is the plane `middle`; `best` places planes across it, and is asked
    /// for only where they are not in the middle. `cut_cost` as in [`BestCuts::cheapest`].
    pub fn planes<'a>(
        self,
        skip: Skip,
        middle: usize,
        best: impl FnOnce() -> &'a BestCuts,
        cut_cost: f64,
    ) -> Planes {
        match (skip, self.half, self.slabs) {
            (Skip::HalfSplit, HalfCut::Middle, _) | (Skip::KCuts, _, SlabCount::Middle) => {
                Planes::new(&[middle])
            }
            (Skip::HalfSplit, HalfCut::Best, _) => {
                Planes::new(&[best().single().unwrap_or(middle)])
            }
            (Skip::KCuts, _, SlabCount::Auto) => best().cheapest(cut_cost),
            (Skip::KCuts, _, SlabCount::AtMost(slabs)) => best().at_most(slabs),
            _ => Planes::default(),
        }
    }
}

/// Where half-split cuts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum HalfCut {
    /// At the block boundary nearest the middle of the volume.
    #[default]
    Middle,
    /// Where one plane saves most; in the middle where none saves anything.
    Best,
}

impl HalfCut {
    /// All choices.
    pub const ALL: &[Self] = &[Self::Middle, Self::Best];

    /// The name used by flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Middle => "middle",
            Self::Best => "best",
        }
    }
}

/// How often k-cuts cuts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum SlabCount {
    /// As often as the next cut saves more than it costs.
    #[default]
    Auto,
    /// Once, in the middle: half-split's cut.
    Middle,
    /// Into at most this many slabs, whatever a cut costs; no plane is placed that saves nothing. From 1 to
    /// [`MAX_SLABS`]: more count as that many.
    AtMost(usize),
}

impl std::fmt::Display for SlabCount {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Middle => f.write_str("middle"),
            Self::AtMost(slabs) => write!(f, "{slabs}"),
        }
    }
}

impl std::str::FromStr for SlabCount {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "middle" => Ok(Self::Middle),
            number => number
                .parse()
                .ok()
                .filter(|n| (2..=MAX_SLABS).contains(n))
                .map(Self::AtMost)
                .ok_or_else(|| format!("expected auto, middle or 2 to {MAX_SLABS} slabs")),
        }
    }
}

/// Planes across an axis, ascending, in leaf blocks: plane p lies before layer p.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Planes {
    at: [usize; MAX_SLABS - 1],
    len: usize,
}

impl Planes {
    /// These planes, ascending.
    ///
    /// # Panics
    /// Where they descend, or are more than [`MAX_SLABS`] - 1.
    pub fn new(at: &[usize]) -> Self {
        assert!(at.is_sorted(), "planes ascend");
        let mut planes = Self {
            len: at.len(),
            ..Self::default()
        };
        planes.at[..at.len()].copy_from_slice(at);
        planes
    }

    /// The planes.
    pub fn as_slice(&self) -> &[usize] {
        &self.at[..self.len]
    }

    /// The slabs that they cut `layers` layers into, ascending.
    pub fn slabs(&self, layers: usize) -> impl DoubleEndedIterator<Item = Range<usize>> {
        let start = |i: usize| if i == 0 { 0 } else { self.at[i - 1] };
        let end = move |i: usize| if i == self.len { layers } else { self.at[i] };
        (0..=self.len).map(move |i| start(i)..end(i))
    }
}

/// The planes that leave least to march across one axis of an occupancy, for every number of slabs.
#[derive(Debug, Clone)]
pub struct BestCuts {
    /// Columns of blocks along the axis.
    columns: usize,
    /// `[n - 1]`: for n slabs, the length marched (blocks, summed over the columns) and the planes. Each is shorter than
    /// the one before; the list ends where no plane saves anything.
    by_count: Vec<(u64, Planes)>,
}

impl BestCuts {
    /// Places planes across `axis`.
    pub fn new(occupancy: &Occupancy, axis: usize) -> Self {
        let dims = occupancy.dims;
        let lengths = Lengths::new(occupancy, axis);
        Self {
            columns: dims[(axis + 1) % 3] * dims[(axis + 2) % 3],
            by_count: place(dims[axis], |slab| lengths.of(&slab)),
        }
    }

    /// The planes of at most `slabs` slabs that leave least to march.
    pub fn at_most(&self, slabs: usize) -> Planes {
        self.by_count[slabs.clamp(1, self.by_count.len()) - 1].1
    }

    /// The planes whose length and cost together are least; the fewest of equals. `cut_cost` is that of one plane, in
    /// block lengths marched on every column.
    pub fn cheapest(&self, cut_cost: f64) -> Planes {
        let cost = |cuts: usize| {
            self.by_count[cuts].0 as f64 + cuts as f64 * cut_cost * self.columns as f64
        };
        let least =
            (1..self.by_count.len()).fold(0, |b, cuts| if cost(cuts) < cost(b) { cuts } else { b });
        self.by_count[least].1
    }

    /// The one plane that saves most, if any saves anything.
    pub fn single(&self) -> Option<usize> {
        self.at_most(2).as_slice().first().copied()
    }
}

/// What rays along an axis march in any slab of layers.
struct Lengths {
    layers: usize,
    /// `[j]`: active blocks below layer j.
    active: Vec<u64>,
    /// `[i * (layers + 1) + j]`: summed length of the gaps between an active block at or above layer i and one below j.
    gaps: Vec<u64>,
}

impl Lengths {
    fn new(occupancy: &Occupancy, axis: usize) -> Self {
        let layers = occupancy.dims[axis];
        let stride = layers + 1;
        let mut active = vec![0; stride];
        let mut gaps = vec![0; stride * stride];
        // Each column's last active layer so far, as gaps are met in the order of memory.
        let [u, v] = [0, 1, 2]
            .into_iter()
            .filter(|&a| a != axis)
            .collect::<Vec<_>>()[..]
        else {
            unreachable!("two axes remain of three")
        };
        let mut last = vec![None; occupancy.dims[u] * occupancy.dims[v]];
        for z in 0..occupancy.dims[2] {
            for y in 0..occupancy.dims[1] {
                for (w, &word) in occupancy.row(y, z).iter().enumerate() {
                    let mut bits = word;
                    while bits != 0 {
                        let block = [w * 64 + bits.trailing_zeros() as usize, y, z];
                        bits &= bits - 1;
                        let layer = block[axis];
                        active[layer + 1] += 1;
                        let column = &mut last[block[v] * occupancy.dims[u] + block[u]];
                        if let Some(below) = column.replace(layer) {
                            gaps[below * stride + layer + 1] += (layer - below - 1) as u64;
                        }
                    }
                }
            }
        }
        for j in 1..=layers {
            active[j] += active[j - 1];
        }
        // A slab holds the gaps that begin at its first layer, and those of the slab that begins one later.
        for i in (0..layers).rev() {
            let mut begin_here = 0;
            for j in i + 1..=layers {
                begin_here += gaps[i * stride + j];
                gaps[i * stride + j] = begin_here + gaps[(i + 1) * stride + j];
            }
        }
        Self {
            layers,
            active,
            gaps,
        }
    }

    /// From the first to the last active block in `slab`, summed over the columns.
    fn of(&self, slab: &Range<usize>) -> u64 {
        self.active[slab.end] - self.active[slab.start]
            + self.gaps[slab.start * (self.layers + 1) + slab.end]
    }
}

/// The least length of every number of slabs, and its planes, as long as one more makes it less. Of equal planes the
/// lowest are taken.
fn place(layers: usize, length: impl Fn(Range<usize>) -> u64) -> Vec<(u64, Planes)> {
    // least[j]: of the layers below j in as many slabs as the round says; from[n][j]: where the last of n + 2 begins.
    let mut least: Vec<u64> = (0..=layers).map(|j| length(0..j)).collect();
    let mut found = vec![(least[layers], Planes::default())];
    let mut from: Vec<Vec<usize>> = Vec::new();
    while found.len() < MAX_SLABS.min(layers) {
        let slabs = found.len() + 1;
        let (next, begins): (Vec<u64>, Vec<usize>) = (0..=layers)
            .map(|j| {
                (slabs - 1..j)
                    .map(|i| (least[i] + length(i..j), i))
                    .min()
                    .unwrap_or((u64::MAX / 2, 0))
            })
            .unzip();
        least = next;
        from.push(begins);
        if least[layers] >= found[slabs - 2].0 {
            break;
        }
        let mut planes = Planes {
            len: slabs - 1,
            ..Planes::default()
        };
        let mut end = layers;
        for cut in (0..slabs - 1).rev() {
            end = from[cut][end];
            planes.at[cut] = end;
        }
        found.push((least[layers], planes));
    }
    found
}

/// The hulls of the slabs between these planes.
#[derive(Debug, Clone, Copy)]
pub struct KCuts<'a> {
    /// Which blocks are active.
    pub occupancy: &'a Occupancy,
    /// The axis that the planes are perpendicular to.
    pub axis: usize,
    /// The planes, from 0 to `occupancy.dims[axis]`.
    pub planes: Planes,
}

impl KCuts<'_> {
    /// The slab that the ray enters first comes first: k only grows.
    pub(super) fn segments(&self, line: &Line) -> Listed {
        let planes = self.planes.as_slice();
        let [mut from, end] = line.span();
        let mut listed = Listed::default();
        for i in 0..=planes.len() {
            let to = if i == planes.len() {
                end
            } else {
                let next = if line.ascends(self.axis) {
                    planes[i]
                } else {
                    planes[planes.len() - 1 - i]
                };
                // A ray that stays in one slab, or touches another in a point, has one hull. So has one parallel to
                // the planes, whose crossings are infinite.
                line.crossing(self.axis, (next * self.occupancy.block) as f64)
                    .clamp(from, end)
            };
            // Slabs of no length have no samples, unless the whole ray is one sample; the list drops its copies.
            let has_samples = from < to || line.span()[0] == end;
            if has_samples && let Some(hull) = line.hull(self.occupancy, [from, to]) {
                listed.push(line.padded(hull));
            }
            from = to;
        }
        listed
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn occupancies() -> impl Strategy<Value = Occupancy> {
        let dims = prop::array::uniform3(1usize..9);
        (
            dims,
            prop::collection::vec(any::<[prop::sample::Index; 3]>(), 0..40),
        )
            .prop_map(|(dims, active)| {
                let mut occupancy = Occupancy::new(dims.map(|n| n * 4), 4);
                for block in active {
                    occupancy.set(std::array::from_fn(|a| block[a].index(dims[a])));
                }
                occupancy
            })
    }

    /// From the first to the last active block of each column in a slab, counted block by block.
    fn marched(occupancy: &Occupancy, axis: usize, slab: &Range<usize>) -> u64 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let mut sum = 0;
        for a in 0..occupancy.dims[u] {
            for b in 0..occupancy.dims[v] {
                let is_active = |&layer: &usize| {
                    let mut block = [0; 3];
                    (block[axis], block[u], block[v]) = (layer, a, b);
                    occupancy.get(block)
                };
                let first = slab.clone().find(is_active);
                let last = slab.clone().rfind(is_active);
                sum += first.zip(last).map_or(0, |(f, l)| l - f + 1);
            }
        }
        sum as u64
    }

    fn marched_all(occupancy: &Occupancy, axis: usize, planes: &Planes) -> u64 {
        planes
            .slabs(occupancy.dims[axis])
            .map(|slab| marched(occupancy, axis, &slab))
            .sum()
    }

    /// Every choice of planes inside the volume.
    fn all_planes(layers: usize) -> impl Iterator<Item = Planes> {
        (0u32..1 << (layers - 1)).filter_map(move |chosen| {
            let mut planes = Planes::default();
            for plane in (1..layers).filter(|p| chosen >> (p - 1) & 1 == 1) {
                *planes.at.get_mut(planes.len)? = plane;
                planes.len += 1;
            }
            Some(planes)
        })
    }

    proptest! {
        #[test]
        fn no_other_planes_leave_less_or_cost_less(occupancy in occupancies(), axis in 0usize..3, cut_cost in 0.0..1.5f64) {
            let layers = occupancy.dims[axis];
            let best = BestCuts::new(&occupancy, axis);
            let others: Vec<_> = all_planes(layers).map(|p| (p.len, marched_all(&occupancy, axis, &p))).collect();
            for slabs in 1..=MAX_SLABS {
                let planes = best.at_most(slabs);
                prop_assert!(planes.len < slabs);
                prop_assert!(planes.as_slice().is_sorted_by(|a, b| a < b));
                prop_assert!(planes.as_slice().iter().all(|p| (1..layers).contains(p)));
                let ours = marched_all(&occupancy, axis, &planes);
                let least = others.iter().filter(|(cuts, _)| *cuts < slabs).map(|(_, length)| *length).min();
                prop_assert_eq!(Some(ours), least);
                // None of them is for nothing.
                prop_assert!(others.iter().all(|(cuts, length)| *cuts >= planes.len || *length > ours));
            }
            let columns = (occupancy.dims.iter().product::<usize>() / layers) as f64;
            let cost = |cuts: usize, length: u64| length as f64 + cuts as f64 * cut_cost * columns;
            let planes = best.cheapest(cut_cost);
            let ours = cost(planes.len, marched_all(&occupancy, axis, &planes));
            prop_assert!(others.iter().all(|&(cuts, length)| ours <= cost(cuts, length) + 1e-9));
        }
    }

    #[test]
    fn slabs_are_counted_or_chosen() {
        for (text, slabs) in [
            ("auto", SlabCount::Auto),
            ("middle", SlabCount::Middle),
            ("8", SlabCount::AtMost(8)),
        ] {
            assert_eq!(text.parse(), Ok(slabs));
            assert_eq!(slabs.to_string(), text);
        }
        for bad in ["", "1", "9", "-2", "best", "2.0"] {
            assert!(bad.parse::<SlabCount>().is_err(), "{bad}");
        }
    }

    #[test]
    fn planes_go_where_the_cavities_are() {
        // Walls at 1, 3, 9, 15: cavities of 1, 5 and 5 layers.
        let mut occupancy = Occupancy::new([8, 8, 64], 4);
        for layer in [1, 3, 9, 15] {
            occupancy.set([0, 1, layer]);
        }
        let best = BestCuts::new(&occupancy, 2);
        assert_eq!(best.at_most(1).as_slice(), [0usize; 0]);
        assert_eq!(best.single(), Some(4));
        assert_eq!(best.at_most(3).as_slice(), [4, 10]);
        assert_eq!(best.at_most(8).as_slice(), [2, 4, 10]);
        // On four columns a cut of 1 1/4 block lengths costs all that a cavity of 5 saves, and there are fewer of equals.
        assert_eq!(best.cheapest(1.25).as_slice(), [0usize; 0]);
        assert_eq!(best.cheapest(1.2).as_slice(), [4, 10]);
        assert_eq!(best.cheapest(0.2).as_slice(), [2, 4, 10]);
        assert_eq!(BestCuts::new(&occupancy, 0).single(), None);
    }
}
