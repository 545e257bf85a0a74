//! Outputs: whole or not at all, and never in the place of an input.

use super::common::Folder;
use std::fs;

#[test]
fn outputs_that_cannot_be_written_are_refused_before_the_work() {
    let folder = Folder::with_demo("outputs");
    fs::create_dir(folder.path("inner")).unwrap();
    let (before, examples) = (folder.list(), folder.read("demo.npz"));
    let train = "train demo.npz -o";
    let eval = "eval demo.sinew demo.npz --write-vertices";
    for (command, expected) in [
        (format!("{train} no/new.sinew"), "cannot write no/new.sinew: there is no folder no"),
        (format!("{train} inner"), "cannot write inner: it is a folder"),
        (format!("{train} new/"), "cannot write new/: it is a folder"),
        (format!("{train} demo.npz"), "cannot write demo.npz: it is an input"),
        (format!("{train} inner/../demo.json"), "cannot write inner/../demo.json: it is an input"),
        (
            format!("{train} new.glb"),
            "cannot write new.glb: a model is no .glb file, name it .sinew",
        ),
        (
            "report demo.sinew demo.npz -o new.PDF".to_owned(),
            "cannot write new.PDF: a report is no .pdf file, name it .html",
        ),
        (format!("{train} new --record demo.npz"), "cannot write demo.npz: it is an input"),
        (format!("{train} new --record no/r"), "cannot write no/r: there is no folder no"),
        (format!("{train} new --record ./new"), "cannot write new: model and record are one file"),
        (format!("{eval} no/out.npy"), "cannot write no/out.npy: there is no folder no"),
        (format!("{eval} demo.sinew"), "cannot write demo.sinew: it is an input"),
        (format!("{eval} demo.npz"), "cannot write demo.npz: it is an input"),
    ] {
        assert_eq!(folder.sinew(&command).failed(), expected);
        assert_eq!(folder.list(), before, "{command}");
    }
    assert!(folder.read("demo.npz") == examples);
    let line = folder.sinew("demo -o demo.npz").failed();
    assert_eq!(line, "cannot make the folder demo.npz: it is a file");
    let line = folder.sinew("export-demo demo.npz").failed();
    assert_eq!(line, "cannot make the folder demo.npz: it is a file");
}

#[test]
fn a_closed_pipe_is_no_failure_and_no_panic() {
    let folder = Folder::with_demo("pipe");
    for arguments in ["inspect demo.sinew", "inspect demo.sinew --json", "eval demo.sinew demo.npz"]
    {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = folder.command(arguments);
        let run = command.stdout(writer).stderr(std::process::Stdio::piped()).spawn().unwrap();
        let output = run.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    }
}

/// A file that may not grow stands for a disk that is full.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_everything_as_it_was() {
    let folder = Folder::with_demo("full");
    fs::write(folder.path("record.json"), "old").unwrap();
    let before: Vec<_> = folder.list().into_iter().map(|name| folder.read(&name)).collect();
    let sinew = env!("CARGO_BIN_EXE_sinew");
    // Enough for the record, which is written first, and not for the model.
    for (blocks, arguments, named) in [
        (40, "train demo.npz -o demo.sinew --record record.json --proxies 4", "demo.sinew"),
        (1, "train demo.npz -o demo.sinew --record record.json --proxies 4", "record.json"),
        (1, "eval demo.sinew demo.npz --write-vertices demo.npy", "demo.npy"),
    ] {
        let mut command = std::process::Command::new("sh");
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec '{sinew}' {arguments}");
        command.args(["-c", &script]).current_dir(folder.path(""));
        let line = folder.run(command).failed();
        assert!(line.starts_with(&format!("cannot write {named}: ")), "{line}");
        let after: Vec<_> = folder.list().into_iter().map(|name| folder.read(&name)).collect();
        assert!(after == before, "{:?}", folder.list());
    }
}
