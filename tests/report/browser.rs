//! A page in headless Chromium.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

const WATCH: &str = include_str!("watch.js");
const PROBE: &str = include_str!("probe.js");

/// Chromium draws in software here: minutes on a machine that is busy.
const LONGEST: Duration = Duration::from_secs(240);

/// The browser's program, if the machine has one.
pub(crate) fn find() -> Option<PathBuf> {
    let names = [
        "chromium",
        "chromium-browser",
        "google-chrome",
        "google-chrome-stable",
    ];
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let candidates = names
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    candidates.into_iter().find(|program| starts(program))
}

/// Whether it is a browser: the package of that name may hold a stub that only says how to install one.
fn starts(program: &Path) -> bool {
    let asked = Command::new(program)
        .arg("--version")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    asked.is_ok_and(|status| status.success())
}

/// What a reader of the page sees who presses all its buttons, in a window of the given width.
pub(crate) fn probed(program: &Path, page: &Path, width: u32) -> Value {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let html = fs::read_to_string(page).expect("the page is there");
    let copy = html.replacen("<head>", &format!("<head><script>{WATCH}</script>"), 1);
    let end = copy.rfind("</body>").expect("the page has an end");
    let copy = format!("{}<script>{PROBE}</script>{}", &copy[..end], &copy[end..]);
    let copied = folder.path().join("page.html");
    fs::write(&copied, copy).expect("it can be written");
    let dumped = folder.path().join("dumped.html");
    let output = fs::File::create(&dumped).expect("it can be written");
    let child = Command::new(program)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--disable-dev-shm-usage",
            "--virtual-time-budget=60000",
            "--dump-dom",
        ])
        .arg(format!("--window-size={width},1000"))
        .arg(format!(
            "--user-data-dir={}",
            folder.path().join("user").display()
        ))
        .arg(format!("file://{}", copied.display()))
        .stdin(Stdio::null())
        .stdout(output)
        .stderr(Stdio::null())
        .spawn()
        .expect("the browser starts");
    wait(child);
    let dumped = fs::read_to_string(&dumped).expect("the browser writes UTF-8");
    let result = dumped
        .rsplit_once("<pre id=\"result\">")
        .and_then(|(_, rest)| rest.split_once("</pre>"));
    let (json, _) = result.expect("the page's scripts came to their end");
    let json = json
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&amp;", "&");
    serde_json::from_str(&json).expect("it is JSON")
}

fn wait(mut child: Child) {
    let since = Instant::now();
    while child.try_wait().expect("it can be asked").is_none() {
        if since.elapsed() > LONGEST {
            let _ = child.kill();
            let _ = child.wait();
            panic!("the browser was not done after {LONGEST:?}");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}
