//! What the values of a point in an E57 file mean.

use ::e57::{PointCloud, Record, RecordDataType, RecordName, RecordValue};
use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};

/// Where a point's values are among its record, and how they are to be taken.
#[derive(Debug)]
pub(super) struct Layout {
    types: Vec<RecordDataType>,
    cartesian: Option<[usize; 3]>,
    cartesian_invalid: Option<usize>,
    spherical: Option<[usize; 3]>,
    spherical_invalid: Option<usize>,
    normal: Option<[usize; 3]>,
    color: Option<[usize; 3]>,
    color_invalid: Option<usize>,
    intensity: Option<usize>,
    intensity_invalid: Option<usize>,
    /// Row and column in the grid.
    cell: Option<[usize; 2]>,
    rotation: UnitQuaternion<f64>,
    translation: Vector3<f64>,
}

impl Layout {
    pub(super) fn of(cloud: &PointCloud) -> Self {
        let find = |name: RecordName| cloud.prototype.iter().position(|r| r.name == name);
        let triple = |names: [RecordName; 3]| {
            let [a, b, c] = names.map(find);
            Some([a?, b?, c?])
        };
        let pose = cloud.transform.clone().unwrap_or_default();
        let (q, t) = (pose.rotation, pose.translation);
        let rotation = UnitQuaternion::try_new(Quaternion::new(q.w, q.x, q.y, q.z), 0.0);
        Self {
            types: cloud
                .prototype
                .iter()
                .map(|r| r.data_type.clone())
                .collect(),
            cartesian: triple([
                RecordName::CartesianX,
                RecordName::CartesianY,
                RecordName::CartesianZ,
            ]),
            cartesian_invalid: find(RecordName::CartesianInvalidState),
            spherical: triple([
                RecordName::SphericalRange,
                RecordName::SphericalAzimuth,
                RecordName::SphericalElevation,
            ]),
            spherical_invalid: find(RecordName::SphericalInvalidState),
            normal: normals(&cloud.prototype),
            color: triple([
                RecordName::ColorRed,
                RecordName::ColorGreen,
                RecordName::ColorBlue,
            ]),
            color_invalid: find(RecordName::IsColorInvalid),
            intensity: find(RecordName::Intensity),
            intensity_invalid: find(RecordName::IsIntensityInvalid),
            cell: find(RecordName::RowIndex)
                .zip(find(RecordName::ColumnIndex))
                .map(Into::into),
            rotation: rotation.unwrap_or_default(),
            translation: Vector3::new(t.x, t.y, t.z),
        }
    }

    fn number(&self, values: &[RecordValue], index: usize) -> f64 {
        let value = values.get(index).zip(self.types.get(index));
        value
            .and_then(|(value, data_type)| value.to_f64(data_type).ok())
            .unwrap_or(f64::NAN)
    }

    fn numbers<const N: usize>(
        &self,
        values: &[RecordValue],
        indices: Option<[usize; N]>,
    ) -> Option<[f64; N]> {
        Some(indices?.map(|index| self.number(values, index)))
    }

    /// States other than 0 are directions without a distance, or nothing.
    fn is_valid(&self, values: &[RecordValue], state: Option<usize>) -> bool {
        state.is_none_or(|index| self.number(values, index).to_bits() << 1 == 0)
    }

    /// The point in the file's common system; `None` where nothing was seen.
    pub(super) fn position(&self, values: &[RecordValue]) -> Option<Point3<f64>> {
        let cartesian = self.numbers(values, self.cartesian);
        let spherical = self.numbers(values, self.spherical);
        let local = cartesian
            .filter(|_| self.is_valid(values, self.cartesian_invalid))
            .or_else(|| {
                let [range, azimuth, elevation] =
                    spherical.filter(|_| self.is_valid(values, self.spherical_invalid))?;
                let [(sin_a, cos_a), (sin_e, cos_e)] = [azimuth, elevation].map(f64::sin_cos);
                Some([range * cos_e * cos_a, range * cos_e * sin_a, range * sin_e])
            })?;
        let position = self.rotation * Vector3::from(local) + self.translation;
        position
            .iter()
            .all(|v| v.is_finite())
            .then(|| position.into())
    }

    /// The normal in the file's common system.
    pub(super) fn normal(&self, values: &[RecordValue]) -> Option<[f64; 3]> {
        let normal = self.numbers(values, self.normal)?;
        Some((self.rotation * Vector3::from(normal)).into())
    }

    pub(super) fn has_color(&self) -> bool {
        self.color.is_some()
    }

    /// Red, green and blue as the file has them; black where they are not known.
    pub(super) fn color(&self, values: &[RecordValue]) -> Option<[f64; 3]> {
        let color = self.numbers(values, self.color)?;
        let is_valid = self.is_valid(values, self.color_invalid);
        Some(if is_valid { color } else { [0.0; 3] })
    }

    /// The intensity as the file has it; NaN where it is not known.
    pub(super) fn intensity(&self, values: &[RecordValue]) -> Option<f64> {
        let intensity = self.number(values, self.intensity?);
        let is_valid = self.is_valid(values, self.intensity_invalid);
        Some(if is_valid { intensity } else { f64::NAN })
    }

    /// Row and column in the grid.
    pub(super) fn cell(&self, values: &[RecordValue]) -> Option<[i64; 2]> {
        let [row, column] = self.cell?;
        let index = |k: usize| values.get(k)?.to_i64(self.types.get(k)?).ok();
        Some([index(row)?, index(column)?])
    }

    /// What stands for no and for full intensity of colours, as far as the file says.
    pub(super) fn color_range(&self, cloud: &PointCloud) -> Option<[f64; 2]> {
        let usable =
            |[low, high]: [f64; 2]| (high > low && (high - low).is_finite()).then_some([low, high]);
        let limits = cloud.color_limits.as_ref().and_then(|limits| {
            let plain = |value: &Option<RecordValue>| match value {
                Some(RecordValue::Integer(v)) => {
                    RecordValue::Integer(*v).to_f64(&RecordDataType::U8).ok()
                }
                Some(RecordValue::Single(v)) => Some(f64::from(*v)),
                Some(RecordValue::Double(v)) => Some(*v),
                // Its scale is not told.
                Some(RecordValue::ScaledInteger(_)) | None => None,
            };
            usable([plain(&limits.red_min)?, plain(&limits.red_max)?])
        });
        limits.or_else(|| {
            let data_type = self.types.get(self.color?[0])?;
            match *data_type {
                RecordDataType::Integer { min, max } if min > i64::MIN && max < i64::MAX => {
                    let [min, max] = [min, max].map(|v| RecordValue::Integer(v).to_f64(data_type));
                    usable([min.ok()?, max.ok()?])
                }
                RecordDataType::Single { min, max } => usable([min?.into(), max?.into()]),
                RecordDataType::Double { min, max } => usable([min?, max?]),
                _ => None,
            }
        })
    }
}

/// The normals of the extension `nor`.
fn normals(prototype: &[Record]) -> Option<[usize; 3]> {
    let find = |searched: &str| {
        prototype
            .iter()
            .position(|r| matches!(&r.name, RecordName::Unknown { name, .. } if name == searched))
    };
    Some([find("normalX")?, find("normalY")?, find("normalZ")?])
}
