//! The WGSL in a browser: another compiler than wgpu's, where one is installed.

use sinew_gpu::layout::Stage;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Makes a pipeline of every stage and sends back what the browser says of each, a line a stage.
const PAGE: &str = "<!doctype html><script>
(async () => {
  const said = [];
  try {
    const adapter = await navigator.gpu.requestAdapter();
    const device = await adapter.requestDevice();
    for (const [name, code] of Object.entries(STAGES)) {
      const module = device.createShaderModule({ code });
      const compute = { module, entryPoint: 'main' };
      const pipeline = device.createComputePipelineAsync({ layout: 'auto', compute });
      await pipeline.then(() => said.push(name + ' ok'), (error) => said.push(name + ' ' + error));
    }
  } catch (error) {
    said.push('no device: ' + error);
  }
  await fetch('/said', { method: 'POST', body: said.join('\\n') });
})();
</script>";

#[test]
fn a_browser_takes_every_stage() {
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let is_there = |name: &&str| Command::new(name).arg("--version").output().is_ok();
    let Some(browser) = names.into_iter().find(is_there) else {
        let missing = "not run in a browser: there is no chromium (Debian: chromium)";
        assert!(std::env::var_os("CI").is_none(), "{missing}");
        eprintln!("{missing}");
        return;
    };
    let spoilt = |stage: Stage, code: &str| {
        if stage == Stage::Skin {
            code.replace("3.4028234e+38", "3.40282347e+38")
        } else {
            code.into()
        }
    };
    let said = in_browser(browser, |_, code| code.to_owned());
    assert_eq!(said.lines().count(), Stage::ALL.len(), "{said}");
    assert!(said.lines().all(|line| line.ends_with(" ok")), "{said}");
    // wgpu's own compiler rounds this number, others refuse it.
    let said = in_browser(browser, spoilt);
    assert_eq!(said.lines().filter(|line| line.contains(" ok")).count(), Stage::ALL.len() - 1);
}

/// Opens a page with the stages' sources; returns what it has to say.
fn in_browser(browser: &str, source: impl Fn(Stage, &str) -> String) -> String {
    let stages = Stage::ALL.map(|stage| {
        let code = source(stage, stage.wgsl());
        assert!(!code.contains(['`', '\\', '$']), "it can stand in a template literal");
        format!("{}: `{code}`", stage.name())
    });
    let page = PAGE.replace("STAGES", &format!("{{{}}}", stages.join(",")));
    let server = TcpListener::bind("127.0.0.1:0").expect("a port is free");
    let port = server.local_addr().expect("it has an address").port();
    let profile = std::env::temp_dir().join(format!("sinew-browser-{}-{port}", std::process::id()));
    let mut running = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-background-networking", "--no-first-run"])
        .args(["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"])
        .args(["--remote-debugging-port=0", &format!("--user-data-dir={}", profile.display())])
        .arg(format!("http://127.0.0.1:{port}/"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the browser starts");
    server.set_nonblocking(true).expect("it need not wait");
    // A browser that does not answer must not hold the tests up.
    let start = Instant::now();
    let mut said = None;
    while said.is_none() && start.elapsed() < Duration::from_secs(60) {
        match server.accept() {
            Ok((stream, _)) => said = answer(stream, &page),
            Err(_) => std::thread::sleep(Duration::from_millis(10)),
        }
    }
    let _ = running.kill();
    let _ = running.wait();
    let _ = std::fs::remove_dir_all(profile);
    said.expect("the browser answers within a minute")
}

/// Answers a request with the page; returns the body of the one that says something.
fn answer(mut stream: TcpStream, page: &str) -> Option<String> {
    stream.set_nonblocking(false).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(30))).ok()?;
    let mut lines = BufReader::new(stream.try_clone().ok()?);
    let (mut line, mut len, mut posted) = (String::new(), 0, false);
    while lines.read_line(&mut line).ok()? > 2 {
        posted |= line.starts_with("POST");
        let header = line.to_ascii_lowercase();
        len =
            header.strip_prefix("content-length:").map_or(Some(len), |n| n.trim().parse().ok())?;
        line.clear();
    }
    let mut body = vec![0; len];
    lines.read_exact(&mut body).ok()?;
    let head = "HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\nConnection: close";
    write!(stream, "{head}\r\nContent-Length: {}\r\n\r\n{page}", page.len()).ok()?;
    posted.then(|| String::from_utf8_lossy(&body).into_owned())
}
