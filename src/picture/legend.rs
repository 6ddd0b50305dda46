//! What colours mean: a color bar with numbers, or a list of colours, in a column right of the scan.

use super::canvas::Raster;
use super::color_map::ColorMap;
use super::params::Background;
use super::text::Type;
use super::ticks::ticks;

/// Longest text, in characters; longer ones are cut.
const LONGEST: usize = 20;
/// Most share of the picture's width.
const WIDEST: f64 = 0.4;
/// Share of the picture's height that a color bar takes.
const TALL: f64 = 0.62;
/// Width of a color bar, and space between things, in lines of text.
const BAR: f64 = 1.3;
const SPACE: f64 = 0.5;
/// Least height of a color bar, in lines of text.
const LEAST_LINES: u32 = 4;

/// What colours mean.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Legend {
    /// A color bar.
    Bar {
        title: String,
        /// Empty for none.
        unit: String,
        range: [f64; 2],
        map: ColorMap,
    },
    /// Colours and their names.
    Keys(Vec<([u8; 3], String)>),
}

/// A legend with its place on a picture.
#[derive(Debug, Clone)]
pub(super) struct Column<'a> {
    legend: &'a Legend,
    kind: Type,
    /// Where it begins.
    left: u32,
    /// How wide it is.
    pub(super) width: u32,
    /// The picture's.
    height: u32,
    /// Numbers of the color bar.
    ticks: Vec<(f64, String)>,
}

impl<'a> Column<'a> {
    /// The legend's place on a picture of this size; `None` if it has no room there.
    pub(super) fn place(legend: &'a Legend, width: u32, height: u32) -> Option<Self> {
        let kind = Type::for_picture(height);
        let mut column = Self {
            legend,
            kind,
            left: 0,
            width: 0,
            height,
            ticks: Vec::new(),
        };
        let lines = |n: f64| n * f64::from(kind.height());
        let inner = match legend {
            Legend::Bar { range, .. } => {
                let most = column.bar_height() / (2 * kind.height()).max(1);
                column.ticks = ticks(*range, most.clamp(2, 8) as usize);
                let numbers = column.ticks.iter().map(|(_, text)| kind.width(text)).max();
                let bar = pixels(lines(BAR + SPACE)) + numbers.unwrap_or(0);
                let titles = column.titles().into_iter().map(|text| kind.width(&text));
                titles.fold(bar, u32::max)
            }
            Legend::Keys(keys) => {
                let texts = keys.iter().map(|(_, text)| kind.width(&cut(text)));
                pixels(lines(1.0 + SPACE)) + texts.max().unwrap_or(0)
            }
        };
        column.width = inner + pixels(lines(2.0 * SPACE));
        column.left = width.checked_sub(column.width)?;
        let fits = f64::from(column.width) <= WIDEST * f64::from(width)
            && column.bar_height() >= LEAST_LINES * kind.height();
        fits.then_some(column)
    }

    fn bar_height(&self) -> u32 {
        pixels(TALL * f64::from(self.height))
    }

    fn titles(&self) -> Vec<String> {
        match self.legend {
            Legend::Bar { title, unit, .. } if unit.is_empty() => vec![cut(title)],
            Legend::Bar { title, unit, .. } => vec![cut(title), cut(&format!("({unit})"))],
            Legend::Keys(_) => Vec::new(),
        }
    }

    /// Draws the legend.
    pub(super) fn draw(&self, raster: &mut Raster, background: Background) {
        let ink = ink(background);
        let line = self.kind.height();
        let space = pixels(SPACE * f64::from(line));
        let left = self.left + space;
        match self.legend {
            Legend::Bar { range, map, .. } => {
                let titles = self.titles();
                let heading = line * u32::try_from(titles.len()).unwrap_or(0) + space;
                let top = (self.height - self.bar_height()) / 2;
                for (k, title) in (0..).zip(&titles) {
                    let y = (top + heading / 2).saturating_sub(heading) + k * line;
                    self.kind.write(raster, title, left, y, ink);
                }
                let top = top + heading / 2;
                self.draw_bar(raster, *range, *map, [left, top], ink);
            }
            Legend::Keys(keys) => {
                let step = line + space;
                let count = u32::try_from(keys.len()).unwrap_or(0);
                let mut y = (self.height / 2).saturating_sub(step * count / 2);
                for (color, text) in keys {
                    fill(raster, [left, y], [line, line], *color, ink);
                    self.kind
                        .write(raster, &cut(text), left + line + space, y, ink);
                    y += step;
                }
            }
        }
    }

    fn draw_bar(
        &self,
        raster: &mut Raster,
        [low, high]: [f64; 2],
        map: ColorMap,
        [left, top]: [u32; 2],
        ink: [u8; 3],
    ) {
        let line = self.kind.height();
        let [width, height] = [pixels(BAR * f64::from(line)), self.bar_height()];
        for row in 0..height {
            let share = 1.0 - (f64::from(row) + 0.5) / f64::from(height);
            let color = map.color(share);
            for column in 0..width {
                raster.lay(left + column, top + row, color, 1.0);
            }
        }
        frame(raster, [left, top], [width, height], ink);
        let space = pixels(SPACE * f64::from(line));
        for (value, text) in &self.ticks {
            let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
            let y = top + pixels((1.0 - share) * f64::from(height - 1));
            for x in left + width..left + width + space / 2 {
                raster.lay(x, y, ink, 1.0);
            }
            // Glyphs stand a little above the middle of their line.
            let y = y.saturating_sub(line / 2);
            self.kind.write(raster, text, left + width + space, y, ink);
        }
    }
}

/// Dark on light, light on dark.
fn ink(background: Background) -> [u8; 3] {
    match background {
        Background::Color([r, g, b])
            if 299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b) < 110_000 =>
        {
            [225; 3]
        }
        _ => [40; 3],
    }
}

fn fill(raster: &mut Raster, [left, top]: [u32; 2], size: [u32; 2], color: [u8; 3], ink: [u8; 3]) {
    for y in 0..size[1] {
        for x in 0..size[0] {
            raster.lay(left + x, top + y, color, 1.0);
        }
    }
    frame(raster, [left, top], size, ink);
}

fn frame(raster: &mut Raster, [left, top]: [u32; 2], [width, height]: [u32; 2], ink: [u8; 3]) {
    for x in 0..width {
        raster.lay(left + x, top, ink, 1.0);
        raster.lay(left + x, top + height - 1, ink, 1.0);
    }
    for y in 0..height {
        raster.lay(left, top + y, ink, 1.0);
        raster.lay(left + width - 1, top + y, ink, 1.0);
    }
}

fn cut(text: &str) -> String {
    if text.chars().count() <= LONGEST {
        return text.to_owned();
    }
    let start: String = text.chars().take(LONGEST - 2).collect();
    format!("{start}..")
}

fn pixels(length: f64) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "lengths on a picture, not negative"
    )]
    let pixels = length.round() as u32;
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar() -> Legend {
        Legend::Bar {
            title: "height".to_owned(),
            unit: "scan units".to_owned(),
            range: [-1.0, 1.0],
            map: ColorMap::Diverging,
        }
    }

    #[test]
    fn a_color_bar_has_its_colors_in_order_and_text_beside_them() {
        let legend = bar();
        let column = Column::place(&legend, 800, 600).unwrap();
        assert!(column.width < 250);
        let white = Background::Color([255; 3]);
        let mut raster = Raster::filled(800, 600, white);
        column.draw(&mut raster, white);
        let middle = column.left + 20;
        let [upper, lower] = [150, 480].map(|y| raster.pixel(middle, y).unwrap());
        assert!(
            upper[0] > upper[2] && lower[2] > lower[0],
            "{upper:?} {lower:?}"
        );
        let dark_in = |x: std::ops::Range<u32>, y: std::ops::Range<u32>| {
            let pixels = y.flat_map(|y| x.clone().map(move |x| (x, y)));
            pixels
                .filter(|(x, y)| raster.pixel(*x, *y).unwrap()[1] < 100)
                .count()
        };
        // The title above it, numbers right of it, nothing left of the column.
        assert!(dark_in(column.left..800, 80..125) > 60);
        assert!(dark_in(column.left + 40..800, 130..500) > 60);
        assert_eq!(dark_in(0..column.left, 0..600), 0);
    }

    #[test]
    fn small_pictures_have_no_room_for_a_legend() {
        let legend = bar();
        assert!(Column::place(&legend, 200, 600).is_none());
        assert!(Column::place(&legend, 800, 60).is_none());
        let keys = Legend::Keys(vec![([1, 2, 3], "original".to_owned())]);
        assert!(Column::place(&keys, 400, 300).is_some());
        assert!(Column::place(&keys, 16, 16).is_none());
    }

    #[test]
    fn keys_show_their_colors() {
        let keys = Legend::Keys(vec![
            ([10, 200, 30], "one".to_owned()),
            (
                [200, 10, 30],
                "a name that is much too long for a legend".to_owned(),
            ),
        ]);
        let column = Column::place(&keys, 1600, 1200).unwrap();
        let mut raster = Raster::filled(1600, 1200, Background::Transparent);
        column.draw(&mut raster, Background::Transparent);
        for color in [[10, 200, 30, 255], [200, 10, 30, 255]] {
            assert!(
                raster
                    .pixels
                    .iter()
                    .filter(|pixel| **pixel == color)
                    .count()
                    > 300
            );
        }
    }
}
