//! A headless Chromium, spoken to in its DevTools protocol through two pipes: no port, no library.
//!
//! With `--remote-debugging-pipe` it reads requests from file descriptor 3 and writes answers and
//! events to 4, each a JSON text that ends with a zero byte; the shell puts our pipes there.

use std::{
    collections::BTreeSet,
    io::{BufRead, BufReader, Write},
    path::Path,
    process::{Child, ChildStdin, Command, Stdio},
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Longer than anything here takes, on the slowest machine.
const PATIENCE: Duration = Duration::from_secs(120);

const FLAGS: [&str; 12] = [
    "--headless",
    "--no-sandbox",
    "--remote-debugging-pipe",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-breakpad",
    "--disable-component-update",
    "--disable-dev-shm-usage",
    "--disable-quic",
    "--disable-sync",
    "--hide-scrollbars",
    "--mute-audio",
];

/// WebGL without a GPU, and none at all.
const SOFTWARE_GL: [&str; 2] = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const NO_GL: [&str; 2] = ["--disable-gpu", "--disable-3d-apis"];

/// A browser with one page.
pub(crate) struct Browser {
    child: Child,
    requests: ChildStdin,
    messages: Receiver<Value>,
    events: Vec<Value>,
    session: Option<String>,
    n_requests: u64,
    /// Its profile, new and empty.
    _home: TempDir,
}

impl Browser {
    /// With WebGL, or without.
    pub(crate) fn start(webgl: bool) -> Self {
        let home = tempfile::tempdir().unwrap();
        let mut child = Command::new("sh")
            .args(["-c", r#"exec "$@" 3<&0 4>&1 </dev/null >/dev/null 2>&1"#, "sh", "chromium"])
            .args(FLAGS)
            .args(if webgl { SOFTWARE_GL } else { NO_GL })
            .arg(format!("--user-data-dir={}", home.path().display()))
            .arg("about:blank")
            .env("HOME", home.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let requests = child.stdin.take().unwrap();
        let mut answers = BufReader::new(child.stdout.take().unwrap());
        let (sender, messages) = channel();
        thread::spawn(move || {
            let mut message = Vec::new();
            while answers.read_until(0, &mut message).is_ok_and(|n| n > 0) {
                message.pop();
                let value = serde_json::from_slice(&message).unwrap();
                message.clear();
                if sender.send(value).is_err() {
                    break;
                }
            }
        });
        let (events, session) = (Vec::new(), None);
        let mut browser =
            Self { child, requests, messages, events, session, n_requests: 0, _home: home };
        let page = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let target = json!({ "targetId": page["targetId"], "flatten": true });
        let attached = browser.call("Target.attachToTarget", target);
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    fn call(&mut self, method: &str, params: Value) -> Value {
        self.n_requests += 1;
        let mut request = json!({ "id": self.n_requests, "method": method, "params": params });
        if let Some(session) = &self.session {
            request["sessionId"] = json!(session);
        }
        let sent = self.requests.write_all(format!("{request}\0").as_bytes());
        sent.expect("chromium runs: it's among the packages of `make setup`");
        loop {
            let message = self.messages.recv_timeout(PATIENCE);
            let mut message =
                message.expect("chromium answers: it's among the packages of `make setup`");
            if message["id"] == json!(self.n_requests) {
                assert!(message.get("error").is_none(), "{method}: {message}");
                return message["result"].take();
            }
            self.events.push(message);
        }
    }

    pub(crate) fn open(&mut self, page: &Path) {
        let url = format!("file://{}", page.display());
        self.call("Page.navigate", json!({ "url": url }));
        self.wait_until("document.readyState === 'complete' && location.protocol === 'file:'");
        self.settle();
    }

    /// A window of so many pixels; what's laid out by its size has been by then.
    pub(crate) fn resize(&mut self, width: u32, height: u32) {
        let metrics = json!({
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false,
        });
        self.call("Emulation.setDeviceMetricsOverride", metrics);
        self.settle();
    }

    /// Waits for two pictures: what was asked for has been drawn in the second.
    pub(crate) fn settle(&mut self) {
        let frame =
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))";
        self.run(frame);
    }

    /// The value of a JavaScript expression, waited for if it's a promise.
    #[track_caller]
    pub(crate) fn run(&mut self, expression: &str) -> Value {
        let params = json!({
            "expression": expression, "awaitPromise": true, "returnByValue": true,
        });
        let mut answer = self.call("Runtime.evaluate", params);
        let failed = answer.get("exceptionDetails");
        assert!(failed.is_none(), "{expression}: {failed:?}");
        answer["result"]["value"].take()
    }

    #[track_caller]
    pub(crate) fn text(&mut self, selector: &str) -> String {
        let text = self.run(&format!("document.querySelector({selector:?}).textContent"));
        text.as_str().unwrap().to_owned()
    }

    #[track_caller]
    pub(crate) fn wait_until(&mut self, condition: &str) {
        let start = Instant::now();
        while self.run(condition) != json!(true) {
            assert!(start.elapsed() < PATIENCE, "never: {condition}");
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// What an element looks like: red, green and blue of its pixels.
    #[track_caller]
    pub(crate) fn pixels(&mut self, selector: &str) -> Vec<[u8; 3]> {
        self.run(&format!("document.querySelector({selector:?}).scrollIntoView()"));
        self.settle();
        let place = self.run(&format!(
            "(({{ x, y, width, height }}) => ({{ x: x + scrollX, y: y + scrollY, width, height, scale: 1 }}))
                (document.querySelector({selector:?}).getBoundingClientRect())"
        ));
        let shot = self.call("Page.captureScreenshot", json!({ "format": "png", "clip": place }));
        let bytes = STANDARD.decode(shot["data"].as_str().unwrap()).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut buffer).unwrap();
        let samples = info.color_type.samples();
        let pixels = buffer[..info.buffer_size()].chunks_exact(samples);
        pixels.map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }

    /// What went wrong in the page: errors in its console, exceptions, requests that left the file.
    pub(crate) fn complaints(&mut self) -> Vec<String> {
        self.run("1"); // All events that were on their way are here before its answer.
        let found = self.events.iter().filter_map(|event| {
            let params = &event["params"];
            let wrong = match event["method"].as_str()? {
                "Runtime.exceptionThrown" => true,
                "Runtime.consoleAPICalled" => params["type"] == "error",
                "Log.entryAdded" => params["entry"]["level"] == "error",
                "Network.requestWillBeSent" => {
                    let url = params["request"]["url"].as_str()?;
                    !["file:", "data:", "blob:"].iter().any(|kind| url.starts_with(kind))
                }
                _ => false,
            };
            wrong.then(|| event.to_string())
        });
        found.collect()
    }
}

impl Drop for Browser {
    /// Asks it to end, so that nothing of it writes to its profile any more when that's removed.
    fn drop(&mut self) {
        let _ = self.requests.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(10) {
            if self.child.try_wait().is_ok_and(|ended| ended.is_some()) {
                return;
            }
            thread::sleep(Duration::from_millis(20));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// How many different colours there are.
pub(crate) fn n_colours(pixels: &[[u8; 3]]) -> usize {
    pixels.iter().collect::<BTreeSet<_>>().len()
}

/// The share of pixels that aren't the same.
pub(crate) fn changed(one: &[[u8; 3]], other: &[[u8; 3]]) -> f64 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).filter(|(a, b)| a != b).count() as f64 / one.len() as f64
}
