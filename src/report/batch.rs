//! The page of the command `batch`: many scans on one page.

use std::io::{self, Write};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::markup::{escaped, filled};
use super::number::counted;
use super::page::STYLE;

const SKELETON: &str = include_str!("batch.html");
const OWN_STYLE: &str = include_str!("batch.css");

/// Many scans.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BatchPage {
    /// Its title, for the browser's tab, too.
    pub title: String,
    /// What came out, in one sentence.
    pub lead: String,
    /// In their order.
    pub scans: Vec<BatchScan>,
}

/// One of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BatchScan {
    /// Its file, as the user knows it.
    pub name: String,
    /// How it ended, in a word or two.
    pub status: String,
    /// Why nothing came of it, if nothing did.
    pub error: Option<String>,
    /// Gaps that were filled, and that were left open.
    pub gaps: [Option<u64>; 2],
    /// How long it took.
    pub seconds: f64,
    /// Most memory that it took, in bytes.
    pub peak_memory: Option<u64>,
    /// What was said of it.
    pub warnings: Vec<String>,
    /// What was written: text and address of links.
    pub files: Vec<[String; 2]>,
    /// Pictures as PNG, before and after.
    pub pictures: Vec<Picture>,
}

/// A picture.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Picture {
    /// What it shows, for those who do not see it.
    pub text: String,
    /// PNG.
    pub png: Vec<u8>,
}

impl BatchPage {
    /// Writes the page as one HTML file (UTF-8) that needs nothing else; links go to files that are elsewhere.
    ///
    /// # Errors
    /// If `out` cannot be written to.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        filled(SKELETON, out, |marker, out| match marker {
            "title" => out.write_all(escaped(&self.title).as_bytes()),
            "lead" => out.write_all(escaped(&self.lead).as_bytes()),
            "version" => out.write_all(env!("CARGO_PKG_VERSION").as_bytes()),
            "style" => out.write_all(STYLE.as_bytes()),
            "own_style" => out.write_all(OWN_STYLE.as_bytes()),
            "sections" => self.write_sections(out),
            _ => Ok(()),
        })
    }

    fn write_sections(&self, out: &mut impl Write) -> io::Result<()> {
        let failed: Vec<&BatchScan> = (self.scans.iter())
            .filter(|scan| scan.error.is_some())
            .collect();
        if !failed.is_empty() {
            writeln!(out, "<section>\n<h2>What failed</h2>")?;
            begin_table(
                out,
                "Scans that nothing came of",
                &[("scan", false), ("why", false)],
            )?;
            for scan in &failed {
                let error = scan.error.as_deref().unwrap_or_default();
                writeln!(
                    out,
                    "<tr><th scope=\"row\">{}</th><td>{}</td></tr>",
                    escaped(&scan.name),
                    escaped(error)
                )?;
            }
            writeln!(out, "</tbody></table></div>\n</section>")?;
        }
        writeln!(out, "<section>\n<h2>All scans</h2>")?;
        let columns = [
            ("scan", false),
            ("status", false),
            ("gaps filled", true),
            ("left open", true),
            ("seconds", true),
            ("memory, MiB", true),
            ("files", false),
            ("warnings", false),
        ];
        begin_table(out, "Scans in their order", &columns)?;
        for scan in &self.scans {
            scan.write_row(out)?;
        }
        writeln!(out, "</tbody></table></div>\n</section>")?;
        if self.scans.iter().any(|scan| !scan.pictures.is_empty()) {
            writeln!(
                out,
                "<section>\n<h2>Pictures</h2>\n<div class=\"pictures\">"
            )?;
            for scan in &self.scans {
                scan.write_pictures(out)?;
            }
            writeln!(out, "</div>\n</section>")?;
        }
        Ok(())
    }
}

fn begin_table(out: &mut impl Write, caption: &str, columns: &[(&str, bool)]) -> io::Result<()> {
    // Wide tables scroll in a box of their own; with the keyboard it must have the focus.
    write!(
        out,
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\"><table>\n<caption>{caption}</caption>\n<thead><tr>"
    )?;
    for (heading, is_number) in columns {
        let class = if *is_number { " class=\"number\"" } else { "" };
        write!(out, "<th scope=\"col\"{class}>{heading}</th>")?;
    }
    writeln!(out, "</tr></thead>\n<tbody>")
}

impl BatchScan {
    fn write_row(&self, out: &mut impl Write) -> io::Result<()> {
        let [filled, left] = self
            .gaps
            .map(|count| count.map_or(String::new(), |count| count.to_string()));
        let memory = self
            .peak_memory
            .map_or(String::new(), |bytes| (bytes >> 20).to_string());
        let links: Vec<String> = (self.files.iter())
            .map(|[text, address]| {
                format!("<a href=\"{}\">{}</a>", escaped(address), escaped(text))
            })
            .collect();
        let class = if self.error.is_some() {
            " class=\"failed\""
        } else {
            ""
        };
        writeln!(
            out,
            "<tr><th scope=\"row\">{}</th><td{class}>{}</td><td class=\"number\">{filled}</td><td class=\"number\">{left}</td><td class=\"number\">{:.1}</td><td class=\"number\">{memory}</td><td>{}</td><td>{}</td></tr>",
            escaped(&self.name),
            escaped(&self.status),
            self.seconds,
            links.join(", "),
            self.told_warnings()
        )
    }

    /// How many there are, to be opened.
    fn told_warnings(&self) -> String {
        if self.warnings.is_empty() {
            return String::new();
        }
        let count = counted(self.warnings.len(), "warning", "warnings");
        let all: String = (self.warnings.iter())
            .map(|warning| format!("<p>{}</p>", escaped(warning)))
            .collect();
        format!("<details><summary>{count}</summary>{all}</details>")
    }

    fn write_pictures(&self, out: &mut impl Write) -> io::Result<()> {
        if self.pictures.is_empty() {
            return Ok(());
        }
        write!(
            out,
            "<figure><figcaption>{}</figcaption><div>",
            escaped(&self.name)
        )?;
        for picture in &self.pictures {
            write!(
                out,
                "<img alt=\"{}\" loading=\"lazy\" src=\"data:image/png;base64,{}\">",
                escaped(&picture.text),
                BASE64_STANDARD.encode(&picture.png)
            )?;
        }
        writeln!(out, "</div></figure>")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(name: &str, error: Option<&str>) -> BatchScan {
        BatchScan {
            name: name.to_owned(),
            status: "some status".to_owned(),
            error: error.map(str::to_owned),
            gaps: [Some(7), None],
            warnings: vec![name.to_owned()],
            files: vec![[name.to_owned(), "a%20b.ply".to_owned()]],
            pictures: vec![Picture {
                text: name.to_owned(),
                png: vec![1, 2, 3],
            }],
            ..BatchScan::default()
        }
    }

    fn written(scans: Vec<BatchScan>) -> String {
        let page = BatchPage {
            title: "title".to_owned(),
            lead: "lead".to_owned(),
            scans,
        };
        let mut out = Vec::new();
        page.write(&mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn failures_come_first_and_only_where_there_are_any() {
        let html = written(vec![scan("good", None), scan("bad", Some("cut off"))]);
        let at = |text: &str| html.find(text).unwrap();
        assert!(at("cut off") < at("All scans"));
        assert!(at("All scans") < at("good"));
        assert_eq!(html.matches("<figure>").count(), 2);
        assert_eq!(html.matches("data:image/png;base64,AQID").count(), 2);
        assert!(html.trim_end().ends_with("</html>"));
        let html = written(vec![scan("good", None)]);
        assert!(!html.contains("What failed"));
    }

    #[test]
    fn markup_in_names_is_harmless() {
        let hostile = "\"><script>alert(1)</script>{{lead}}";
        let html = written(vec![scan(hostile, Some(hostile))]);
        assert!(!html.contains("<script"));
        assert!(!html.contains("\">&lt;script"));
        assert_eq!(html.matches("<p class=\"lead\">").count(), 1);
    }
}
