//! Text as a Rockable shape file: shapes or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sturz_engine::shape::{Shape, rockable_shapes};

fuzz_target!(|text: &str| {
    for shape in rockable_shapes(text).into_iter().flatten() {
        let _ = Shape::build(&shape.description);
    }
});
