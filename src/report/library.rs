//! The plotting library that pages carry.

use super::ReportError;

/// plotly.js, as the crate `plotly` carries it; without `MathJax`, which that adds: pages have no formulas.
#[cfg(feature = "report")]
pub(super) fn plotly_js() -> Result<String, ReportError> {
    let sources = plotly::Plot::offline_js_sources();
    let script = sources
        .split_once('>')
        .and_then(|(_, behind)| behind.split_once("</script>"))
        .map(|(script, _)| script.to_owned());
    script
        .filter(|script| script.contains("plotly.js"))
        .ok_or_else(|| {
            std::io::Error::other("the crate plotly does not give plotly.js as it used to").into()
        })
}

/// Says what this build lacks.
#[cfg(not(feature = "report"))]
pub(super) fn plotly_js() -> Result<String, ReportError> {
    Err(ReportError::NotBuiltIn)
}

/// Whether this build can write pages: worth asking before long work.
///
/// # Errors
/// [`ReportError::NotBuiltIn`] if it cannot.
pub fn check_built() -> Result<(), ReportError> {
    if cfg!(feature = "report") {
        Ok(())
    } else {
        Err(ReportError::NotBuiltIn)
    }
}

#[cfg(all(test, feature = "report"))]
mod tests {
    use super::*;

    #[test]
    fn the_library_comes_alone_and_can_stand_in_a_script_element() {
        let script = plotly_js().unwrap();
        assert!(script.contains("plotly.js v3."), "{}", &script[..100]);
        assert!(!script.contains("</script"));
        // With MathJax it would be 7 MB.
        assert!(script.len() < 5_000_000, "{}", script.len());
    }
}
