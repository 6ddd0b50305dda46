//! Results to a page that one can send: one HTML file that needs no network, with what was done, tables,
//! plots, and scans to turn in three dimensions.
//!
//! Nothing is computed here but which vertices are shown: figures come in, HTML goes out. A [`Page`] is plain
//! data; one file a command turns the command's results into one ([`completed`], [`compared`], [`textured`], [`transferred`]). The page carries plotly.js,
//! so that it works from `file://` and in ten years. The same page is written in the same bytes.
//!
//! A build without the feature `report` has all of this but plotly.js, and so cannot write pages:
//! [`check_built`] tells. The page of many scans, [`BatchPage`], has neither plots nor scripts, and any build writes it.

mod batch;
mod completed;
mod compared;
mod error;
mod histograms;
mod library;
mod markup;
mod number;
mod page;
mod plot;
mod scanned;
mod settings;
mod table;
mod textured;
mod thinned;
mod transferred;
mod view;
mod words;

pub use batch::{BatchPage, BatchScan, Picture};
pub use compared::{Compared, Measurement, compared};
pub use completed::{Completed, completed};
pub use error::ReportError;
pub use library::check_built;
pub use page::{Block, Page, Section};
pub use plot::{Axis, Marks, Part, Plot, Series};
pub use table::{Column, Table};
pub use textured::{TexturedPage, textured};
pub use transferred::{TransferredPage, transferred};
pub use view::{Channel, MOST_SHOWN, Values, View};
