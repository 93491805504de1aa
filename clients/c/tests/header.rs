//! The header is that of the sources: made anew, and compared with the one in `include`.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use cbindgen::{Builder, Config};

/// In the order of the header.
const SOURCES: [&str; 8] = ["code", "failure", "simulation", "state", "fluid", "exchange", "loads", "window"];
/// Behind them.
const LAST: &str = "participant";

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn header() -> PathBuf {
    package().join("include/sturz.h")
}

fn made() -> String {
    let config = Config::from_file(package().join("cbindgen.toml")).expect("the configuration is sound");
    let mut builder = Builder::new().with_config(config);
    for source in SOURCES.into_iter().chain([LAST]) {
        builder = builder.with_src(package().join("src").join(source).with_extension("rs"));
    }
    let mut text = Vec::new();
    builder.generate().expect("the sources are sound").write(&mut text);
    String::from_utf8(text).expect("UTF-8")
}

#[test]
fn the_header_is_that_of_the_sources() {
    let made = made();
    // Alone, as the others read it: `STURZ_WRITE_HEADER=1 cargo test -p sturz-c --test header of_the_sources`.
    if env::var_os("STURZ_WRITE_HEADER").is_some() {
        fs::write(header(), &made).unwrap();
    }
    let there = fs::read_to_string(header()).unwrap();
    let differs = there.lines().zip(made.lines()).position(|(there, made)| there != made);
    assert!(
        there == made,
        "include/sturz.h is not that of the sources (first at line {:?}): run this test with STURZ_WRITE_HEADER=1",
        differs.map(|line| line + 1)
    );
}

/// Every source with something for C is in the header.
#[test]
fn no_function_is_left_out() {
    let header = fs::read_to_string(header()).unwrap();
    let mut functions = 0;
    for entry in fs::read_dir(package().join("src")).unwrap() {
        let source = fs::read_to_string(entry.unwrap().path()).unwrap();
        for line in source.lines().filter(|line| line.starts_with("pub ") && line.contains("extern \"C\" fn ")) {
            let name = line.split("fn ").nth(1).and_then(|rest| rest.split('(').next()).unwrap();
            assert!(header.contains(&format!("{name}(")), "{name} is not in the header");
            functions += 1;
        }
    }
    assert!(functions >= 30, "only {functions} functions were found");
}

#[test]
fn the_endpoint_in_the_header_is_that_of_the_client() {
    let header = fs::read_to_string(header()).unwrap();
    assert!(header.contains(&format!("#define STURZ_DEFAULT_ENDPOINT {:?}", sturz_client::DEFAULT_ENDPOINT)));
}

/// Strict C99, and C++ where a compiler is at hand.
#[test]
fn compilers_take_the_header_without_a_warning() {
    let check = |compiler: &str, arguments: &[&str]| {
        Command::new(compiler)
            .args(arguments)
            .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-include"])
            .arg(header())
            .arg("/dev/null")
            .output()
    };
    let cc = check("cc", &["-std=c99", "-x", "c"]).expect("there is a C compiler `cc`: the tests need a C toolchain");
    assert!(cc.status.success(), "{}", String::from_utf8_lossy(&cc.stderr));
    if let Ok(cxx) = check("c++", &["-std=c++11", "-x", "c++"]) {
        assert!(cxx.status.success(), "{}", String::from_utf8_lossy(&cxx.stderr));
    }
}
