//! Colour maps: values to colours.

use super::canvas::linear;

/// Entries of a table: more than eight bits can tell apart.
const ENTRIES: usize = 1024;

/// A colour map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColorMap {
    /// Viridis (van der Walt & Smith 2015): perceptually uniform, and readable by the color-blind.
    Sequential,
    /// From blue over white to red, of equal steps to both sides (`RdBu` of `ColorBrewer`, Brewer 2003).
    Diverging,
}

impl ColorMap {
    /// The sRGB colour at a share of the way from the lowest to the highest value.
    pub(super) fn color(self, share: f64) -> [u8; 3] {
        let share = share.clamp(0.0, 1.0);
        let color = match self {
            Self::Sequential => colorous::VIRIDIS.eval_continuous(share),
            Self::Diverging => colorous::RED_BLUE.eval_continuous(1.0 - share),
        };
        [color.r, color.g, color.b]
    }

    /// The map in linear light.
    pub(super) fn table(self) -> Vec<[f32; 3]> {
        (0..ENTRIES)
            .map(|k| self.color(k as f64 / (ENTRIES - 1) as f64).map(linear))
            .collect()
    }
}

/// The entry of a table at a share of its way; the ends beyond it.
pub(super) fn look_up(table: &[[f32; 3]], share: f64) -> [f32; 3] {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float cast saturates"
    )]
    let entry = (share * (table.len() - 1) as f64).round() as usize;
    table[entry.min(table.len() - 1)]
}

/// A colour for a place: hue and saturation follow the first two coordinates, lightness the third, each from
/// −1 to 1. Linear light.
///
/// # Reference
/// Oklab, B. Ottosson, "A perceptual color space for image processing", 2020.
pub(super) fn of_place([a, b, l]: [f64; 3]) -> [f64; 3] {
    let (lightness, a, b) = (0.7 + 0.12 * l, 0.16 * a, 0.16 * b);
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    ]
    .map(|light| light.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_values_are_blue_and_high_ones_red_and_zero_is_pale() {
        let [low, middle, high] = [0.0, 0.5, 1.0].map(|share| ColorMap::Diverging.color(share));
        assert!(low[2] > low[0] && high[0] > high[2]);
        assert!(middle.iter().all(|value| *value > 230));
        assert_eq!(ColorMap::Diverging.color(-3.0), low);
    }

    #[test]
    fn viridis_gets_lighter_all_the_way() {
        let lights: Vec<f64> = (ColorMap::Sequential.table().iter())
            .map(|[r, g, b]| {
                0.2126 * f64::from(*r) + 0.7152 * f64::from(*g) + 0.0722 * f64::from(*b)
            })
            .collect();
        assert!(lights.windows(40).all(|pair| pair[39] > pair[0]));
    }

    #[test]
    fn tables_end_at_their_ends() {
        let table = ColorMap::Sequential.table();
        let bits = |color: [f32; 3]| color.map(f32::to_bits);
        for (share, entry) in [(-1.0, 0), (2.0, ENTRIES - 1), (f64::NAN, 0)] {
            assert_eq!(bits(look_up(&table, share)), bits(table[entry]));
        }
    }

    #[test]
    fn places_far_apart_have_colors_far_apart() {
        let corners = [
            [-1.0, -1.0, 0.0],
            [1.0, -1.0, 0.0],
            [-1.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
        ];
        let colors = corners.map(of_place);
        for (k, a) in colors.iter().enumerate() {
            for b in &colors[..k] {
                let distance: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
                assert!(distance > 0.3, "{a:?} {b:?}");
            }
        }
        let middle = of_place([0.0; 3]);
        assert!(
            middle.iter().all(|light| (light - 0.343).abs() < 1e-3),
            "{middle:?}"
        );
    }
}
