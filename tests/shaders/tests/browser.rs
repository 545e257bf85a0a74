//! Compiles the WGSL in a browser, if one is installed: a different compiler from wgpu's.

use pages::browser;
use sinew_gpu::layout::Stage;

/// Makes a pipeline of every stage and sends back the browser's result, one line per stage.
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
    let Some(browser) = browser::browser() else { return };
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
    // wgpu's compiler rounds this number; other compilers refuse it.
    let said = in_browser(browser, spoilt);
    assert_eq!(said.lines().filter(|line| line.contains(" ok")).count(), Stage::ALL.len() - 1);
}

/// Opens a page with the stages' sources; returns its report.
fn in_browser(browser: &str, source: impl Fn(Stage, &str) -> String) -> String {
    let stages = Stage::ALL.map(|stage| {
        let code = source(stage, stage.wgsl());
        assert!(!code.contains(['`', '\\', '$']), "it can stand in a template literal");
        format!("{}: `{code}`", stage.name())
    });
    let page = PAGE.replace("STAGES", &format!("{{{}}}", stages.join(",")));
    let webgpu = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"];
    browser::said(browser, &webgpu, &[("/", "text/html; charset=utf-8", page.as_bytes())])
}
