//! What lies under the relief: a surface with a formula, or free form.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::BaseSurface;

/// The smooth shape under the relief of a part of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Form {
    /// A plane, sphere, cylinder or cone.
    Primitive(BaseSurface),
    /// The smoothest surface near the scan, see [`super::smooth_form`].
    Free(FreeForm),
}

/// Free form: no more is known of it than what it leaves to the relief.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename = "freeform")]
pub struct FreeForm {
    /// Half of a wave of this length is form, half of it relief; in the scan's unit.
    pub wavelength: f64,
}

impl Form {
    /// The same form moved by `offset`.
    #[must_use]
    pub fn translated(self, offset: Vector3<f64>) -> Self {
        match self {
            Self::Primitive(base) => Self::Primitive(base.translated(offset)),
            Self::Free(_) => self,
        }
    }

    /// The surface with a formula, if it is one.
    #[must_use]
    pub fn primitive(&self) -> Option<&BaseSurface> {
        match self {
            Self::Primitive(base) => Some(base),
            Self::Free(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Sphere;
    use nalgebra::Point3;

    #[test]
    fn forms_are_told_apart_when_they_are_read_back() {
        let sphere = Form::Primitive(BaseSurface::Sphere(Sphere {
            center: Point3::new(1.0, 2.0, 3.0),
            radius: 0.5,
        }));
        let free = Form::Free(FreeForm { wavelength: 2.5 });
        for form in [sphere, free] {
            let json = serde_json::to_string(&form).unwrap();
            assert_eq!(serde_json::from_str::<Form>(&json).unwrap(), form, "{json}");
        }
        assert_eq!(
            serde_json::to_string(&free).unwrap(),
            r#"{"kind":"freeform","wavelength":2.5}"#
        );
    }
}
