//! Height maps that parameters cannot be told of.

use thiserror::Error;

/// Why a height map has no parameters, in one sentence with a remedy.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ArealError {
    /// A map has three columns, three rows and nine known heights, all its sides' steps positive.
    #[error(
        "{columns} columns by {rows} rows with {known} known heights are too few; give at least 3 by 3, all known"
    )]
    TooFewHeights {
        /// Number of columns.
        columns: usize,
        /// Number of rows.
        rows: usize,
        /// Number of heights that are not missing.
        known: usize,
    },
    /// Steps and filters are positive, finite lengths.
    #[error("the {what} of {length} is not a positive length; give one above 0")]
    NotPositive {
        /// What is not.
        what: &'static str,
        /// Its value.
        length: f64,
    },
    /// A form is determined by the known heights.
    #[error(
        "the known heights do not determine a form of {coefficients} coefficients (they are too few, or lie in lines); choose a simpler one, such as mean"
    )]
    FormNotDetermined {
        /// Number of coefficients of the form.
        coefficients: usize,
    },
    /// A filter's cut-off is not longer than the map.
    #[error(
        "the cut-off {length} of the {filter} is longer than the map's shorter side of {side}; give a shorter one, or a larger map"
    )]
    FilterTooLong {
        /// `S-filter` or `L-filter`.
        filter: &'static str,
        /// Its cut-off.
        length: f64,
        /// The shorter side of the map.
        side: f64,
    },
    /// The S-filter takes away shorter waves than the L-filter.
    #[error(
        "the S-filter's cut-off {s_filter} is not below the L-filter's {l_filter}, so that nothing would be left; the S-filter takes the short waves away"
    )]
    NothingLeft {
        /// Cut-off of the S-filter.
        s_filter: f64,
        /// Cut-off of the L-filter.
        l_filter: f64,
    },
}
