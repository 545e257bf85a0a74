//! The compiler, glslang.

use anyhow::{Context, Result, anyhow};
use glslang::include::{IncludeHandler, IncludeResult, IncludeType};
use glslang::{
    Compiler, CompilerOptions, ShaderInput, ShaderMessage, ShaderSource, ShaderStage,
    SourceLanguage, SpirvVersion, Target, VulkanVersion,
};
use std::fs;
use std::path::Path;

/// Compiles a compute shader to SPIR-V 1.0 for Vulkan 1.0, as little-endian words.
///
/// # Errors
/// If a file cannot be read, or is not valid GLSL; the message is glslang's.
pub fn compile(source: &Path) -> Result<Vec<u8>> {
    let name = || source.display().to_string();
    let text = fs::read_to_string(source).with_context(name)?;
    let text = ShaderSource::from(text);
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        target: Target::Vulkan {
            version: VulkanVersion::Vulkan1_0,
            spirv_version: SpirvVersion::SPIRV1_0,
        },
        version_profile: None,
        messages: ShaderMessage::DEFAULT,
    };
    let compiler = Compiler::acquire().ok_or_else(|| anyhow!("glslang does not start"))?;
    let mut beside = Beside(source.parent().unwrap_or(Path::new(".")));
    let defines = None::<&[(&str, Option<&str>)]>;
    let input = ShaderInput::new(&text, ShaderStage::Compute, &options, defines, Some(&mut beside))
        .with_context(name)?;
    let words = compiler.create_shader(input).and_then(|shader| shader.compile());
    Ok(words.with_context(name)?.into_iter().flat_map(u32::to_le_bytes).collect())
}

/// Include handler that finds files in one folder.
struct Beside<'a>(&'a Path);

impl IncludeHandler for Beside<'_> {
    fn include(
        &mut self,
        _: IncludeType,
        header: &str,
        _: &str,
        _: usize,
    ) -> Option<IncludeResult> {
        let data = fs::read_to_string(self.0.join(header)).ok()?;
        Some(IncludeResult { name: header.to_owned(), data })
    }
}
