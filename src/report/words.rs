//! Things in words.

use super::number::number;
use crate::base::{BaseSurface, Form};

/// A base in words.
pub(super) fn form(form: &Form) -> String {
    match form {
        Form::Primitive(BaseSurface::Plane(_)) => "a plane".to_owned(),
        Form::Primitive(BaseSurface::Sphere(sphere)) => {
            format!("a sphere of radius {}", number(sphere.radius))
        }
        Form::Primitive(BaseSurface::Cylinder(cylinder)) => {
            format!("a cylinder of radius {}", number(cylinder.radius))
        }
        Form::Primitive(BaseSurface::Cone(cone)) => format!(
            "a cone of half angle {}\u{b0}",
            number(cone.half_angle.to_degrees())
        ),
        Form::Free(free) => format!("free form of wavelength {}", number(free.wavelength)),
    }
}

/// Numbers of loops.
pub(super) fn loops(ids: &[usize]) -> String {
    let ids: Vec<String> = ids.iter().map(ToString::to_string).collect();
    ids.join(", ")
}
