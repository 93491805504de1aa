//! Generates the message types from `proto/` with protox (no protoc), and the descriptor set that
//! `tests/schema.rs` compares with the committed one.

use std::{env, error::Error, fs, path::PathBuf};

use prost::Message as _;

const FILES: [&str; 3] = ["sturz/v1/data.proto", "sturz/v1/command.proto", "sturz/v1/status.proto"];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=proto");
    let mut set = protox::compile(FILES, ["proto"])?;
    // Columns are read out of the message that they came in, without a copy.
    prost_build::Config::new().bytes(["."]).compile_fds(set.clone())?;
    // Comments and positions change without the schema changing.
    set.file.iter_mut().for_each(|file| file.source_code_info = None);
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR")?);
    fs::write(out.join("descriptor.binpb"), set.encode_to_vec())?;
    Ok(())
}
