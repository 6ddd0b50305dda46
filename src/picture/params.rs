//! What a picture shows, from where, and how large.

use serde::Serialize;

use crate::base::FitParams;

use super::PictureError;

/// Smallest width and height, in pixels: less shows nothing.
pub const SMALLEST_SIDE: u32 = 16;
/// Largest width and height, in pixels.
pub const LARGEST_SIDE: u32 = 16_384;
/// Most pixels: one takes 32 bytes while it is drawn, all together 1 GiB.
pub const MOST_PIXELS: u64 = 1 << 25;
/// Largest zoom, and one over the smallest: coordinates on the picture stay small enough for exact
/// arithmetic in 64 bits.
pub const LARGEST_ZOOM: f64 = 100.0;

/// What the colours of a picture stand for.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ChannelChoice {
    /// The scan's colours if it has any, else its shape.
    #[default]
    Auto,
    /// The scan's colours.
    Color,
    /// Nothing: one plain colour.
    Shape,
    /// Signed height over the base surface: the property `height`, or else over the base that fits.
    Height,
    /// Original and completed faces.
    Completed,
    /// What the match of each completed vertex cost: the property `cost`.
    Cost,
    /// Where completed vertices were copied from: the property `source`.
    Source,
    /// Any other vertex property.
    Property(String),
}

/// From where a scan is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum View {
    /// A surface that faces one side: from there. Others as [`Iso`](Self::Iso), turned around the up axis
    /// so that the completed part is seen, if there is one.
    #[default]
    Auto,
    /// From the front: with y up against the z axis, with z up along the y axis, with x up along z.
    Front,
    /// From behind.
    Back,
    /// From the object's left as seen from the front.
    Left,
    /// From the object's right as seen from the front.
    Right,
    /// From above.
    Top,
    /// From below.
    Bottom,
    /// From the front, a little from the right and from above.
    Iso,
    /// By angles in radians.
    Angles {
        /// From the front towards the object's right.
        azimuth: f64,
        /// Upwards.
        elevation: f64,
    },
}

/// Which axis of the scan points upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// z if the scan is by a fifth longer along z than along x and y; else y.
    #[default]
    Auto,
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

/// How depth is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Projection {
    /// What is nearer is larger, as through a lens of 25°.
    #[default]
    Perspective,
    /// One length everywhere.
    Orthographic,
}

/// What fills the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LookAt {
    /// The whole scan.
    #[default]
    All,
    /// What was completed, and what is around it.
    Completed,
}

/// What is behind the scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Background {
    /// Nothing.
    Transparent,
    /// A colour: red, green and blue (sRGB).
    Color([u8; 3]),
}

/// How a picture is made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RenderParams {
    /// Width in pixels, default 1600.
    pub width: u32,
    /// Height in pixels, default 1200.
    pub height: u32,
    /// What the colours stand for.
    pub channel: ChannelChoice,
    /// Values at the two ends of the color bar; by default the 2 % and 98 % quantiles, around 0 for heights.
    pub range: Option<[f64; 2]>,
    /// From where.
    pub view: View,
    /// What is up.
    pub up: Up,
    /// How depth is drawn.
    pub projection: Projection,
    /// Enlarges the middle of the picture by this factor, default 1.
    pub zoom: f64,
    /// What fills the picture.
    pub look_at: LookAt,
    /// Leaves out completed faces; camera and color bar are those of the completed scan.
    pub before: bool,
    /// Draws the edges of the triangles.
    pub wireframe: bool,
    /// Draws a color bar, or what the colours mean, beside the scan; default true.
    pub legend: bool,
    /// What is behind the scan, default white.
    pub background: Background,
    /// How the base surface is fitted that heights are over where the scan has no property `height`.
    #[serde(skip)]
    pub fit: FitParams,
}

impl Default for RenderParams {
    fn default() -> Self {
        Self {
            width: 1600,
            height: 1200,
            channel: ChannelChoice::Auto,
            range: None,
            view: View::Auto,
            up: Up::Auto,
            projection: Projection::Perspective,
            zoom: 1.0,
            look_at: LookAt::All,
            before: false,
            wireframe: false,
            legend: true,
            background: Background::Color([255; 3]),
            fit: FitParams::default(),
        }
    }
}

impl RenderParams {
    /// Whether the parameters are in range.
    ///
    /// # Errors
    /// [`PictureError::Size`], [`PictureError::Zoom`], [`PictureError::Range`] or [`PictureError::Angles`].
    pub fn check(&self) -> Result<(), PictureError> {
        let (width, height) = (self.width, self.height);
        let sides = SMALLEST_SIDE..=LARGEST_SIDE;
        if !sides.contains(&width)
            || !sides.contains(&height)
            || u64::from(width) * u64::from(height) > MOST_PIXELS
        {
            return Err(PictureError::Size { width, height });
        }
        if !(1.0 / LARGEST_ZOOM..=LARGEST_ZOOM).contains(&self.zoom) {
            return Err(PictureError::Zoom(self.zoom));
        }
        if let Some([low, high]) = self.range
            && !(low < high && (high - low).is_finite())
        {
            return Err(PictureError::Range([low, high]));
        }
        if let View::Angles { azimuth, elevation } = self.view
            && !(azimuth.is_finite() && elevation.is_finite())
        {
            return Err(PictureError::Angles);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_zooms_and_ranges_out_of_bounds_are_refused() {
        let sized = |width, height| RenderParams {
            width,
            height,
            ..RenderParams::default()
        };
        assert_eq!(RenderParams::default().check(), Ok(()));
        assert_eq!(sized(16, 16_384).check(), Ok(()));
        for (width, height) in [
            (0, 0),
            (0, 600),
            (800, 15),
            (100_000, 100_000),
            (16_384, 16_384),
        ] {
            let error = sized(width, height).check().unwrap_err();
            assert_eq!(error, PictureError::Size { width, height });
            assert!(error.to_string().contains(&format!("{width} by {height}")));
        }
        for zoom in [0.0, -1.0, f64::NAN, f64::INFINITY, 101.0] {
            let params = RenderParams {
                zoom,
                ..RenderParams::default()
            };
            assert!(matches!(params.check(), Err(PictureError::Zoom(_))));
        }
        for range in [
            [1.0, 1.0],
            [2.0, 1.0],
            [f64::NAN, 1.0],
            [0.0, f64::INFINITY],
        ] {
            let params = RenderParams {
                range: Some(range),
                ..RenderParams::default()
            };
            assert!(matches!(params.check(), Err(PictureError::Range(_))));
        }
    }
}
