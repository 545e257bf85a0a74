//! How `train` is told what to fit: predictors, how near they come, and how many bytes they take.

use super::common::{Folder, Set};
use super::number;
use serde_json::{Value, json};

#[test]
fn each_predictor_can_be_asked_for_and_the_file_keeps_to_its_budget() {
    let folder = Folder::with_demo("predictors");
    for predictor in ["rotational", "kernel"] {
        let train = format!("-q train demo.npz -o new.sinew --predictor {predictor} --proxies 4");
        let free = folder.sinew(&format!("{train} --json")).json();
        assert_eq!(free["predictor"], predictor);
        let candidates = free["report"]["candidates"].as_array().unwrap();
        assert!(candidates.iter().all(|candidate| candidate["predictor"] == predictor));
        let found = folder.sinew("eval new.sinew demo.npz --json").json();
        // Fewer proxies than joints cannot stand for them alone.
        let better = number(&found["rms"]) < number(&found["lbs"]["rms"]);
        assert!(better || predictor != "kernel", "{predictor}: {found}");
        assert!(folder.sinew("inspect new.sinew").done().out.contains(predictor));
        let bytes = free["model_bytes"].as_u64().unwrap();
        if predictor == "rotational" {
            continue;
        }
        let budget = bytes - 200;
        let tight = folder.sinew(&format!("{train} --budget {budget} --json")).json();
        assert!(tight["model_bytes"].as_u64().unwrap() <= budget, "{predictor}");
        assert_eq!(folder.read("new.sinew").len() as u64, tight["model_bytes"].as_u64().unwrap());
    }
    let before = folder.read("new.sinew");
    let line = folder.sinew("train demo.npz -o new.sinew --budget 1000").failed();
    let expected = "demo.npz: a budget of 1000 bytes is too small: skeleton and mesh alone take ";
    let least = line.strip_prefix(expected).and_then(|least| least.parse().ok());
    let least: usize = least.expect(&line);
    let line = folder.sinew(&format!("train demo.npz -o new.sinew --budget {least}")).failed();
    let expected = format!(
        "demo.npz: a budget of {least} bytes is too small: the smallest model that was tried takes "
    );
    assert!(line.starts_with(&expected), "{line}");
    assert_eq!(folder.read("new.sinew"), before);
}

#[test]
fn the_published_method_is_rotational_and_refuses_what_it_has_not() {
    let folder = Folder::with_demo("published");
    let train = "-q train demo.npz -o new.sinew --published";
    let found = folder.sinew(&format!("{train} --proxies 4 --json")).json();
    assert_eq!(
        (&found["predictor"], &found["options"]["published"]),
        (&json!("rotational"), &json!(true))
    );
    let candidates = found["report"]["candidates"].as_array().unwrap();
    let tried: Vec<_> = candidates.iter().map(|candidate| &candidate["method"]).collect();
    assert_eq!(tried, [&json!("published")]);
    // 4 proxies, and the joints, which near-rigid vertices follow.
    assert_eq!(found["proxies"], 4 + Set::demo().joint_len());
    let same = folder.sinew(&format!("{train} --predictor rotational --proxies 4 --json")).json();
    assert_eq!(same["report"], found["report"]);
    let before = folder.read("new.sinew");
    for (more, expected) in [
        ("--predictor kernel", "--published is a way to fit --predictor rotational, and no other"),
        (
            "--proxies 513",
            "--published: a file has room for 512 proxies, for each takes that of two",
        ),
    ] {
        assert_eq!(folder.sinew(&format!("{train} {more}")).failed(), expected);
    }
    let both = folder.sinew(&format!("{train} --unrefined"));
    assert!(both.err.contains("'--published' cannot be used with '--unrefined'"), "{}", both.err);
    assert_eq!(folder.read("new.sinew"), before);
}

#[test]
fn auto_falls_back_to_the_joints_alone_where_bytes_are_few() {
    let folder = Folder::with_demo("joints-alone");
    let free = folder.sinew("train demo.npz -o free.sinew --json").json();
    let candidates = free["report"]["candidates"].as_array().unwrap();
    let proxies = |candidate: &Value| candidate["proxies"].as_u64().unwrap();
    assert_eq!((proxies(&candidates[0]), candidates[0]["predictor"].as_str()), (0, Some("kernel")));
    // 20 need no trial, for 80 are better than 40.
    assert_eq!(candidates.iter().map(proxies).collect::<Vec<_>>(), [0, 40, 80]);
    assert_eq!(proxies(&candidates[free["report"]["chosen"].as_u64().unwrap() as usize]), 80);

    // What is told of the training gives way to what is evaluated.
    let inspected = folder.sinew("inspect free.sinew --json").json();
    let is_told = |section: &&Value| section["part"] == 2;
    let told = inspected["sections"].as_array().unwrap().iter().filter(is_told);
    let told: u64 = told.map(|section| section["bytes"].as_u64().unwrap()).sum();
    let budget = candidates[0]["bytes"].as_u64().unwrap() - told;
    let few = folder.sinew(&format!("-q train demo.npz -o few.sinew --budget {budget} --json"));
    let few = few.json();
    let tried: Vec<_> =
        few["report"]["candidates"].as_array().unwrap().iter().map(proxies).collect();
    assert!([10, 20, 40, 80].iter().all(|count| tried.contains(count)), "{tried:?}");
    assert!(folder.read("few.sinew").len() as u64 <= budget);
    assert_eq!(folder.sinew("inspect few.sinew --json").json()["envelopes"][0]["proxies"], 0);
    let found = folder.sinew("eval few.sinew demo.npz --json").json();
    let [model, lbs] = [&found, &found["lbs"]].map(|errors| number(&errors["rms"]));
    assert!((model / lbs - 1.0).abs() < 1e-3, "{model} {lbs}");
}

#[test]
fn max_error_takes_the_fewest_proxies_that_meet_it() {
    let folder = Folder::with_demo("max-error");
    let share = |record: &Value| 100.0 * number(&record["report"]["rotational"]["proxy_rms"]);
    let train = "-q train demo.npz --predictor rotational --json -o";
    let met = folder.sinew(&format!("{train} new.sinew --max-error 2")).json();
    assert!(share(&met) <= 2.0);
    let fewer = met["proxies"].as_u64().unwrap() - 1;
    let missed = format!("{train} fewer.sinew --proxies {fewer}");
    assert!(share(&folder.sinew(&missed).json()) > 2.0);

    let helped = "train demo.npz -o helped.sinew --predictor kernel --max-error 0.1 --json";
    let helpers = folder.sinew(helped).json()["proxies"].as_u64().unwrap();
    assert!(helpers >= 4 && (helpers / 4).is_power_of_two(), "{helpers}");

    let mut set = Set::demo();
    let (shape, corners) = set.wholes.get_mut("tris").unwrap();
    shape[0] = 8;
    corners.truncate(24);
    set.write(&folder.path("few.npz"));
    let line = folder.sinew("train few.npz -o none.sinew --max-error 1e-9").failed();
    assert!(line.starts_with("few.npz: 0.000000001 % is out of reach: 8 proxies"), "{line}");
    assert!(!folder.path("none.sinew").exists());
}
