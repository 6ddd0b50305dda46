//! Images as the measures take them.

/// An image, or what was read off a surface at the places of one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Grid {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Row by row from the top: red, green and blue from 0 to 1, as an image file stores them.
    pub(crate) colors: Vec<[f32; 3]>,
    /// Pixels that count; all, if there is none.
    pub(crate) mask: Option<Vec<bool>>,
}

impl Grid {
    /// Of which all pixels count.
    ///
    /// # Panics
    /// If there are not as many colors as pixels.
    pub(crate) fn new(width: usize, height: usize, colors: Vec<[f32; 3]>) -> Self {
        assert_eq!(colors.len(), width * height, "a color for each pixel");
        Self {
            width,
            height,
            colors,
            mask: None,
        }
    }

    /// Whether a pixel counts.
    pub(crate) fn counts(&self, pixel: usize) -> bool {
        self.mask.as_ref().is_none_or(|mask| mask[pixel])
    }

    /// Pixels that count.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = usize> {
        (0..self.colors.len()).filter(|pixel| self.counts(*pixel))
    }

    /// Luma of every pixel (ITU-R BT.709-6, 3.2), of the colors as they are stored.
    pub(crate) fn luma(&self) -> Vec<f64> {
        (self.colors.iter())
            .map(|color| {
                let [red, green, blue] = color.map(f64::from);
                0.2126 * red + 0.7152 * green + 0.0722 * blue
            })
            .collect()
    }

    /// Upper left pixels of the squares all of whose pixels count: from the upper left of the image in steps,
    /// and in each direction the last for which there is room.
    pub(crate) fn squares(&self, side: usize, step: usize) -> Vec<usize> {
        let starts = |length: usize| -> Vec<usize> {
            let Some(last) = length.checked_sub(side) else {
                return Vec::new();
            };
            (0..last).step_by(step).chain([last]).collect()
        };
        let columns = starts(self.width);
        (starts(self.height).iter())
            .flat_map(|top| columns.iter().map(move |left| top * self.width + left))
            .filter(|corner| self.square(*corner, side).all(|pixel| self.counts(pixel)))
            .collect()
    }

    /// Pixels of a square, row by row.
    pub(crate) fn square(&self, corner: usize, side: usize) -> impl Iterator<Item = usize> {
        let width = self.width;
        (0..side * side).map(move |i| corner + i / side * width + i % side)
    }

    /// A rectangle of it.
    pub(crate) fn part(&self, corner: [usize; 2], width: usize, height: usize) -> Self {
        let pixels = || {
            let [left, top] = corner;
            (0..width * height).map(move |i| (top + i / width) * self.width + left + i % width)
        };
        Self {
            width,
            height,
            colors: pixels().map(|pixel| self.colors[pixel]).collect(),
            mask: (self.mask.as_ref()).map(|mask| pixels().map(|pixel| mask[pixel]).collect()),
        }
    }
}

/// What a measure says of the left and the right half of an image, and of its upper and its lower half: the
/// mean. Nothing can be asked to be nearer to the sample than the sample is to itself.
pub(crate) fn between_halves(
    grid: &Grid,
    measure: impl Fn(&Grid, &Grid) -> Option<f64>,
) -> Option<f64> {
    let (width, height) = (grid.width, grid.height);
    let (half, half_height) = (width / 2, height / 2);
    let across = measure(
        &grid.part([0, 0], half, height),
        &grid.part([width - half, 0], half, height),
    )?;
    let down = measure(
        &grid.part([0, 0], width, half_height),
        &grid.part([0, height - half_height], width, half_height),
    )?;
    Some(f64::midpoint(across, down))
}
