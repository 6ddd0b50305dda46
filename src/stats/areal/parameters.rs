//! All areal parameters under the standard's names.

use serde::Serialize;

use super::{HeightParameters, MaterialRatioCurve};

/// Areal surface texture parameters of ISO 25178-2:2021, serialised under the standard's names.
///
/// z is the height about the mean height, A the area of the surface's projection, c(p) the material ratio
/// curve: the height above which the share p of the area lies. Lengths are in the unit of the heights;
/// those across the surface (Sal) in the unit of the map's steps, which for Sdq and Sdr must be the same.
/// `None` (`null` in JSON) where a value is not defined.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ArealParameters {
    /// Arithmetical mean height ∬|z| dA / A; length; 4.2.8.
    #[serde(rename = "Sa")]
    pub sa: f64,
    /// Root mean square height √(∬z² dA / A); length; 4.2.2.
    #[serde(rename = "Sq")]
    pub sq: f64,
    /// Skewness ∬z³ dA / (A Sq³); no unit; 4.2.3. `None` if all heights are equal.
    #[serde(rename = "Ssk")]
    pub ssk: Option<f64>,
    /// Kurtosis ∬z⁴ dA / (A Sq⁴), 3 for normally distributed heights; no unit; 4.2.4. `None` if all heights
    /// are equal.
    #[serde(rename = "Sku")]
    pub sku: Option<f64>,
    /// Maximum peak height max z; length; 4.2.5.
    #[serde(rename = "Sp")]
    pub sp: f64,
    /// Maximum pit depth −min z; length; 4.2.6.
    #[serde(rename = "Sv")]
    pub sv: f64,
    /// Maximum height Sp + Sv; length; 4.2.7.
    #[serde(rename = "Sz")]
    pub sz: f64,
    /// Root mean square gradient √(∬((∂z/∂x)² + (∂z/∂y)²) dA / A); no unit (rise over run); 4.4.2. `None`
    /// where no two neighbours are known.
    #[serde(rename = "Sdq")]
    pub sdq: Option<f64>,
    /// Developed interfacial area ratio (area of the surface / A − 1) · 100; percent; 4.4.3. `None` where no
    /// piece of surface is known.
    #[serde(rename = "Sdr")]
    pub sdr: Option<f64>,
    /// Autocorrelation length, the shortest distance at which the autocorrelation falls to 0.2; length across
    /// the surface; 4.3.2. `None` if it does so nowhere within the map.
    #[serde(rename = "Sal")]
    pub sal: Option<f64>,
    /// Texture aspect ratio, Sal over the longest distance at which the autocorrelation falls to 0.2; no unit, 0
    /// to 1, 1 for isotropic; 4.3.3. `None` if in one direction it does not within the map.
    #[serde(rename = "Str")]
    pub str: Option<f64>,
    /// Texture direction, in which the angular power spectrum is largest, across the grooves of a lay;
    /// degrees, 0 to 180, counterclockwise from x with y upwards; 4.3.4. `None` without any texture.
    #[serde(rename = "Std")]
    pub std: Option<f64>,
    /// Core height, the fall of the equivalent straight line from 0 to 100 %; length; 4.5.4.
    #[serde(rename = "Sk")]
    pub sk: f64,
    /// Reduced peak height, height of the triangle on Smr1 that is as large as the peaks above the core;
    /// length; 4.5.4.
    #[serde(rename = "Spk")]
    pub spk: f64,
    /// Reduced pit depth, height of the triangle on 100 % − Smr2 that is as large as the pits below the core;
    /// length; 4.5.4.
    #[serde(rename = "Svk")]
    pub svk: f64,
    /// Material ratio at the top of the core (the 2021 edition calls it Smrk1); percent; 4.5.4.
    #[serde(rename = "Smr1")]
    pub smr1: f64,
    /// Material ratio at the bottom of the core (the 2021 edition calls it Smrk2); percent; 4.5.4.
    #[serde(rename = "Smr2")]
    pub smr2: f64,
    /// Extreme peak height c(2.5 %) − c(50 %); length; 4.5.3 (Sdc with these ratios).
    #[serde(rename = "Sxp")]
    pub sxp: f64,
    /// Peak material volume Vm(10 %), with Vm(p) = ∫₀ᵖ (c(q) − c(p)) dq; volume over area; 4.5.6.
    #[serde(rename = "Vmp")]
    pub vmp: f64,
    /// Core material volume Vm(80 %) − Vm(10 %); volume over area; 4.5.6.
    #[serde(rename = "Vmc")]
    pub vmc: f64,
    /// Core void volume Vv(10 %) − Vv(80 %), with Vv(p) = ∫ₚ¹ (c(p) − c(q)) dq; volume over area; 4.5.7.
    #[serde(rename = "Vvc")]
    pub vvc: f64,
    /// Pit void volume Vv(80 %); volume over area; 4.5.7.
    #[serde(rename = "Vvv")]
    pub vvv: f64,
}

/// What a value is counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterUnit {
    /// The unit of the heights.
    Height,
    /// The unit of lengths across the surface.
    Length,
    /// Its square.
    Area,
    /// Volume over area, the unit of the heights.
    VolumeOverArea,
    /// Percent.
    Percent,
    /// Degrees.
    Degrees,
    /// None.
    One,
}

/// A line of a table of parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The standard's name.
    pub name: &'static str,
    /// `None` where it is not defined.
    pub value: Option<f64>,
    /// What it is counted in.
    pub unit: ParameterUnit,
    /// What it is, in a few words.
    pub meaning: &'static str,
}

impl ArealParameters {
    /// Those that heights and their weights tell; the others are `None`.
    #[must_use]
    pub fn of_heights(heights: &HeightParameters, curve: &MaterialRatioCurve) -> Self {
        let core = curve.core();
        let volumes = curve.volumes();
        Self {
            sa: heights.sa,
            sq: heights.sq,
            ssk: heights.ssk,
            sku: heights.sku,
            sp: heights.sp,
            sv: heights.sv,
            sz: heights.sz(),
            sdq: None,
            sdr: None,
            sal: None,
            str: None,
            std: None,
            sk: core.sk,
            spk: core.spk,
            svk: core.svk,
            smr1: 100.0 * core.smr1,
            smr2: 100.0 * core.smr2,
            sxp: curve.sxp(),
            vmp: volumes.vmp,
            vmc: volumes.vmc,
            vvc: volumes.vvc,
            vvv: volumes.vvv,
        }
    }

    /// All of them as lines of a table, in the order of the standard's clauses.
    #[must_use]
    pub fn rows(&self) -> [Row; 22] {
        use ParameterUnit::{Degrees, Height, Length, One, Percent, VolumeOverArea};
        let row = |name, value: Option<f64>, unit, meaning| Row {
            name,
            value,
            unit,
            meaning,
        };
        let is = Some::<f64>;
        [
            row("Sq", is(self.sq), Height, "root mean square height"),
            row("Ssk", self.ssk, One, "skewness"),
            row("Sku", self.sku, One, "kurtosis"),
            row("Sp", is(self.sp), Height, "maximum peak height"),
            row("Sv", is(self.sv), Height, "maximum pit depth"),
            row("Sz", is(self.sz), Height, "maximum height"),
            row("Sa", is(self.sa), Height, "arithmetical mean height"),
            row("Sal", self.sal, Length, "autocorrelation length"),
            row("Str", self.str, One, "texture aspect ratio"),
            row("Std", self.std, Degrees, "texture direction"),
            row("Sdq", self.sdq, One, "root mean square gradient"),
            row("Sdr", self.sdr, Percent, "developed interfacial area ratio"),
            row("Sk", is(self.sk), Height, "core height"),
            row("Spk", is(self.spk), Height, "reduced peak height"),
            row("Svk", is(self.svk), Height, "reduced pit depth"),
            row("Smr1", is(self.smr1), Percent, "material ratio of peaks"),
            row(
                "Smr2",
                is(self.smr2),
                Percent,
                "material ratio down to the pits",
            ),
            row("Sxp", is(self.sxp), Height, "extreme peak height"),
            row("Vmp", is(self.vmp), VolumeOverArea, "peak material volume"),
            row("Vmc", is(self.vmc), VolumeOverArea, "core material volume"),
            row("Vvc", is(self.vvc), VolumeOverArea, "core void volume"),
            row("Vvv", is(self.vvv), VolumeOverArea, "pit void volume"),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_json_have_the_same_names_and_values() {
        let samples: Vec<(f64, f64)> = (0..50).map(|i| (f64::from(i * i % 17), 1.0)).collect();
        let heights = HeightParameters::of(samples.iter().copied()).unwrap();
        let curve = MaterialRatioCurve::new(samples).unwrap();
        let parameters = ArealParameters::of_heights(&heights, &curve);
        let json = serde_json::to_value(parameters).unwrap();
        let members = json.as_object().unwrap();
        let rows = parameters.rows();
        assert_eq!(members.len(), rows.len());
        for row in rows {
            assert_eq!(members[row.name].as_f64(), row.value, "{}", row.name);
        }
    }
}
