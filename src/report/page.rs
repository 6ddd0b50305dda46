//! A page as plain data, and its HTML.

use std::io::Write;

use serde::Serialize;

use super::markup::{escaped, filled, json};
use super::view::Shown;
use super::{Plot, ReportError, Table, View, library};

/// The frame of every page: markers stand where a page's own parts go.
const SKELETON: &str = include_str!("page.html");
pub(super) const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
const VIEW_SCRIPT: &str = include_str!("view.js");

/// A page.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Page {
    /// Its title, for the browser's tab, too.
    pub title: String,
    /// What came out, in one sentence.
    pub lead: String,
    /// The rest, in order.
    pub sections: Vec<Section>,
}

/// A part of a page with a heading.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Section {
    /// Its heading.
    pub heading: String,
    /// What is in it, in order.
    pub blocks: Vec<Block>,
}

/// A piece of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A paragraph, as plain text.
    Text(String),
    /// A table.
    Table(Table),
    /// A plot.
    Plot(Plot),
    /// A scan in three dimensions.
    View(View),
}

/// What the page's script draws.
#[derive(Serialize)]
struct Drawn<'a> {
    plots: Vec<&'a Plot>,
    views: Vec<Shown<'a>>,
}

impl Page {
    /// Writes the page as one HTML file (UTF-8) that needs nothing else.
    ///
    /// # Errors
    /// [`ReportError`] if this build has no plotly.js, or `out` cannot be written to.
    pub fn write(&self, out: &mut impl Write) -> Result<(), ReportError> {
        let library = library::plotly_js()?;
        filled(SKELETON, out, |marker, out| match marker {
            "title" => write!(out, "{}", escaped(&self.title)),
            "lead" => write!(out, "{}", escaped(&self.lead)),
            "version" => out.write_all(env!("CARGO_PKG_VERSION").as_bytes()),
            "style" => out.write_all(STYLE.as_bytes()),
            "sections" => self.write_sections(out),
            "data" => out.write_all(json(&self.drawn())?.as_bytes()),
            "plotly" => out.write_all(library.as_bytes()),
            "script" => out.write_all([SCRIPT, VIEW_SCRIPT].concat().as_bytes()),
            _ => {
                debug_assert!(false, "no such part: {marker}");
                Ok(())
            }
        })?;
        Ok(())
    }

    fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.sections.iter().flat_map(|section| &section.blocks)
    }

    fn drawn(&self) -> Drawn<'_> {
        let plots = self.blocks().filter_map(|block| match block {
            Block::Plot(plot) => Some(plot),
            _ => None,
        });
        let views = self.blocks().filter_map(|block| match block {
            Block::View(view) => Some(view.shown()),
            _ => None,
        });
        Drawn {
            plots: plots.collect(),
            views: views.collect(),
        }
    }

    fn write_sections(&self, out: &mut impl Write) -> std::io::Result<()> {
        let (mut plots, mut views) = (0, 0);
        for section in &self.sections {
            writeln!(out, "<section>\n<h2>{}</h2>", escaped(&section.heading))?;
            let mut beside = false;
            for block in &section.blocks {
                // Plots that follow each other stand side by side where there is room.
                let is_plot = matches!(block, Block::Plot(_));
                if is_plot != beside {
                    let tag = if is_plot {
                        "<div class=\"plots\">"
                    } else {
                        "</div>"
                    };
                    writeln!(out, "{tag}")?;
                    beside = is_plot;
                }
                match block {
                    Block::Text(text) => writeln!(out, "<p>{}</p>", escaped(text))?,
                    Block::Table(table) => table.write(out)?,
                    Block::Plot(plot) => {
                        let caption = escaped(&plot.caption);
                        writeln!(
                            out,
                            "<figure class=\"plot\"><figcaption>{caption}</figcaption><div data-plot=\"{plots}\" role=\"img\" aria-label=\"{caption}\"></div></figure>"
                        )?;
                        plots += 1;
                    }
                    Block::View(view) => {
                        view.write(out, views)?;
                        views += 1;
                    }
                }
            }
            let end = if beside {
                "</div>\n</section>"
            } else {
                "</section>"
            };
            writeln!(out, "{end}")?;
        }
        Ok(())
    }
}

#[cfg(all(test, feature = "report"))]
mod tests {
    use super::*;
    use crate::report::{Axis, Column, Marks, Part, Series};

    fn page(text: &str) -> Page {
        let table = Table {
            caption: text.to_owned(),
            columns: vec![Column::words(text), Column::numbers("value")],
            rows: vec![vec![text.to_owned()]],
        };
        let plot = Plot {
            caption: text.to_owned(),
            x: Axis::linear(text),
            y: Axis::logarithmic("share"),
            series: vec![Series {
                name: text.to_owned(),
                part: Part::Original,
                marks: Marks::Line,
                x: vec![0.0, 1.0],
                y: vec![f64::NAN, 2.0],
            }],
        };
        Page {
            title: text.to_owned(),
            lead: text.to_owned(),
            sections: vec![Section {
                heading: text.to_owned(),
                blocks: vec![
                    Block::Text(text.to_owned()),
                    Block::Table(table),
                    Block::Plot(plot),
                ],
            }],
        }
    }

    fn written(page: &Page) -> String {
        let mut out = Vec::new();
        page.write(&mut out).expect("memory takes it");
        String::from_utf8(out).expect("pages are UTF-8")
    }

    #[test]
    fn a_page_has_all_its_parts_once() {
        let html = written(&page("golf ball"));
        assert!(html.starts_with("<!DOCTYPE html>"));
        assert!(html.trim_end().ends_with("</html>"));
        assert!(html.contains("<title>golf ball</title>"));
        assert_eq!(html.matches("<section>").count(), 1);
        assert_eq!(html.matches("data-plot=\"0\"").count(), 1);
        assert!(html.contains("[null,2.0]"));
    }

    #[test]
    fn markup_in_any_text_is_harmless() {
        let plain = written(&page("golf ball"));
        let hostile = "a</script></title><script>alert(1)</script>\"onload='x' {{plotly}} <!--";
        let html = written(&page(hostile));
        for tag in ["<script", "</script", "</title", "<!--", "plotly.js v3"] {
            let count = |text: &str| text.matches(tag).count();
            assert_eq!(count(&html), count(&plain), "{tag}");
        }
        // In JSON a quote has a backslash, in attributes it is told by its name; plotly.js has its own.
        let bare = |html: &str| {
            let count = |text: &str| html.matches(text).count();
            count("\"onload") - count("\\\"onload")
        };
        assert_eq!(bare(&html), bare(&plain));
    }
}
