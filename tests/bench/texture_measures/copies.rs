//! How much of a result is copied in pieces.

/// Where in the sample the color of a pixel is from (column and row), if it is from one pixel.
pub(crate) type Source = Option<[usize; 2]>;

/// What the sources of a result tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Copies {
    /// Share of the pairs of neighboring pixels (side by side, and above each other) whose sources are neighbors in
    /// the same way.
    pub(crate) continued: f64,
    /// Share of the result that its largest piece takes: connected pixels that are copied together.
    pub(crate) largest: f64,
}

/// Sources are row by row. `None` if there are no two neighbors.
pub(crate) fn copies(sources: &[Source], width: usize) -> Option<Copies> {
    let (mut pairs, mut continued) = (0usize, 0usize);
    for pixel in 0..sources.len() {
        for other in after(pixel, sources.len(), width) {
            pairs += 1;
            continued += usize::from(is_continued(sources, width, pixel, other));
        }
    }
    (pairs > 0).then(|| Copies {
        continued: continued as f64 / pairs as f64,
        largest: largest_piece(sources, width) as f64 / sources.len() as f64,
    })
}

/// The right and the lower neighbor.
fn after(pixel: usize, count: usize, width: usize) -> impl Iterator<Item = usize> {
    let right = (!(pixel + 1).is_multiple_of(width)).then_some(pixel + 1);
    let lower = Some(pixel + width).filter(|lower| *lower < count);
    right.into_iter().chain(lower)
}

/// Whether two neighbors, the left or upper one first, are so in the sample.
fn is_continued(sources: &[Source], width: usize, pixel: usize, other: usize) -> bool {
    let (Some([x, y]), Some(beside)) = (sources[pixel], sources[other]) else {
        return false;
    };
    beside
        == if other == pixel + width {
            [x, y + 1]
        } else {
            [x + 1, y]
        }
}

/// Pixels of the largest piece.
fn largest_piece(sources: &[Source], width: usize) -> usize {
    let count = sources.len();
    let mut seen = vec![false; count];
    let mut largest = 0;
    for start in 0..count {
        let mut open = vec![start];
        let mut size = 0;
        while let Some(pixel) = open.pop() {
            if sources[pixel].is_none() || std::mem::replace(&mut seen[pixel], true) {
                continue;
            }
            size += 1;
            let next = after(pixel, count, width)
                .filter(|other| is_continued(sources, width, pixel, *other));
            open.extend(next);
            let left = (!pixel.is_multiple_of(width)).then(|| pixel - 1);
            let before = left.into_iter().chain(pixel.checked_sub(width));
            open.extend(before.filter(|other| is_continued(sources, width, *other, pixel)));
        }
        largest = largest.max(size);
    }
    largest
}
