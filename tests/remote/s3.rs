//! The binary on `s3://`: the same bytes as on the file, and errors that name the object.

use std::fs;

use crate::common::{replay, run as run_local};
use crate::moto::{self, Moto};
use crate::{rayreel, small};

#[test]
fn commands_read_objects_as_they_read_files() {
    let Some(moto) = Moto::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = small(folder.path(), "cornell");
    moto.put("/bucket", b"");
    moto.put("/bucket/a%20folder/cornell.rtrace", &fs::read(&file).unwrap());
    moto.put("/bucket/cornell.rtrace", &fs::read(&file).unwrap());
    for (url, options) in
        [("s3://bucket/cornell.rtrace", "--machine none"), ("s3://bucket/cornell.rtrace", "--machine sgrt-ti2")]
    {
        let local = replay(&file, options).expect(0);
        let far = moto.run(&format!("replay {url} --quiet --json {options}")).expect(0);
        assert_eq!(local.out, far.out, "{options}");
        assert_eq!(far.err, "", "quiet");
    }
    for command in ["info --json", "digest --json", "verify --json --quiet"] {
        let args: Vec<_> = command.split(' ').map(Into::into).chain([file.clone().into_os_string()]).collect();
        let far = moto.run(&format!("{command} s3://bucket/a%20folder/cornell.rtrace")).expect(0);
        assert_eq!(run_local(&args).expect(0).out, far.out, "{command}");
    }
    moto.run(&format!("diff s3://bucket/cornell.rtrace {}", file.display())).expect(0);
    // How many requests that takes is the business of `ranges`: this object is small.
    moto.run("info s3://bucket/cornell.rtrace").expect(0).says(&["fetched ", " bytes in ", ", 0 bytes from the cache"]);
}

#[test]
fn a_sweep_over_objects_is_the_sweep_over_files() {
    let Some(moto) = Moto::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = small(folder.path(), "cornell");
    moto.put("/bucket", b"");
    moto.put("/bucket/cornell.rtrace", &fs::read(&file).unwrap());
    let plan = folder.path().join("plan.toml");
    fs::write(
        &plan,
        "traces = [\"cornell.rtrace\"]\npolicies = [\"full\", \"adaptive\"]\nmachines = [\"sgrt-ti2\", \"none\"]\n",
    )
    .unwrap();
    let place = |name: &str| folder.path().join(name);
    let line = |name: &str| format!("sweep {} -o {} --quiet", plan.display(), place(name).display());
    moto.run(&line("near")).expect(0);
    moto.run(&format!("{} --traces s3://bucket", line("far"))).expect(0);
    for name in ["results.parquet", "results.csv"] {
        let read = |of: &str| fs::read(place(of).join(name)).unwrap();
        assert!(read("near") == read("far"), "{name}");
    }
    let missing = moto.run(&format!("{} --traces s3://other", line("none"))).expect(2);
    missing.says(&["plan.toml:1:11: trace s3://other/cornell.rtrace: ", "no such bucket"]);
}

#[test]
fn errors_name_the_object() {
    let Some(moto) = Moto::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let whole = fs::read(small(folder.path(), "cornell")).unwrap();
    moto.put("/bucket", b"");
    moto.put("/bucket/cut", &whole[..whole.len() - 9]);
    moto.put("/bucket/text", b"this is no trace");
    moto.put("/bucket/empty", b"");
    let mut bad = whole.clone();
    let middle = bad.len() / 2;
    bad[middle] ^= 1;
    moto.put("/bucket/bad", &bad);
    for (url, code, words) in [
        ("s3://bucket/nothing.rtrace", 2, "no such object"),
        ("s3://other/a.rtrace", 2, "no such bucket"),
        ("s3://bucket/cut", 3, "has no index"),
        ("s3://bucket/text", 65, "is not a trace"),
        ("s3://bucket/empty", 69, "cannot open"),
        ("s3://bucket/bad", 65, "byte "),
        ("s3://bucket/", 2, "names no object"),
        ("s3://", 2, "host or a bucket"),
        ("ftp://bucket/a", 2, "s3://, gs://, http:// and https:// are"),
    ] {
        let ran = moto.run(&format!("digest {url}")).expect(code).says(&[url, words]);
        assert_eq!(ran.err.lines().filter(|line| line.starts_with("error")).count(), 1, "{}", ran.err);
        assert!(ran.out.is_empty() && !ran.err.contains("panicked"), "{}", ran.err);
    }
    drop(moto);
    // The port of a server that has gone: nobody listens.
    let ran = moto::run("info s3://bucket/a.rtrace", "http://127.0.0.1:9", "none").expect(69);
    ran.says(&["error: cannot open s3://bucket/a.rtrace", "refused"]);
    let ran = moto::run("info s3://bucket/a.rtrace", "http://127.0.0.1:9", "/dev/null/cache").expect(69);
    ran.says(&["cannot open s3://bucket/a.rtrace"]);
    rayreel!["info", "s3:/bucket/a"].expect(2).says(&["s3:/bucket/a", "No such file"]);
}
