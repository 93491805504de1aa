//! What docs/preparation.md shows is what scenes may say.

use sturz_engine::scene::{Scene, SceneDescription};

/// Materials, pairs and shapes that the page names.
const BASE: &str = r#"
[scene]
name = "page"
gravity_m_per_s2 = [0.0, 0.0, -1.0]
time_step_s = 1e-7
[[material]]
name = "rock"
density_kg_per_m3 = 1.0
[[material]]
name = "glass"
density_kg_per_m3 = 1.0
[[shape]]
name = "pinacoid"
geometry = { kind = "cube", edge_m = 0.008 }
[[shape]]
name = "cube"
geometry = { kind = "cube", edge_m = 0.003 }
"#;

fn pairs() -> String {
    let pair = |a: &str, b: &str| {
        format!("[[material_pair]]\nmaterials = [\"{a}\", \"{b}\"]\nstiffness_n_per_m = 20.0\nrestitution = 0.5\n")
    };
    pair("rock", "rock") + &pair("rock", "glass") + &pair("glass", "glass")
}

fn blocks() -> Vec<String> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/preparation.md");
    let page = std::fs::read_to_string(path).unwrap();
    page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap().to_string()).collect()
}

fn plan(text: &str) -> Vec<String> {
    let description = SceneDescription::from_toml(text).unwrap_or_else(|error| panic!("{text}\n{error}"));
    Scene::validate(description).unwrap_or_else(|error| panic!("{text}\n{error}")).plan().lines.clone()
}

#[test]
fn every_block_of_the_page_is_read() {
    let insertion = "[[insertion]]\nshape = \"cube\"\nmaterial = \"glass\"\n";
    let base = BASE.to_string() + &pairs();
    let mut seen = Vec::new();
    for block in blocks() {
        let first = block.split([' ', '\n']).next().unwrap_or_default().to_string();
        match first.as_str() {
            "scale" => {
                for line in block.lines() {
                    let poses = "placement = { method = \"poses\", positions_m = [[0.0, 0.0, 0.0]] }\n";
                    plan(&format!("{base}{insertion}{poses}{line}\n"));
                }
            }
            "placement" => drop(plan(&format!("{base}{insertion}{block}"))),
            "[[insertion]]" => {
                let plan = plan(&format!("{base}{block}"));
                assert!(plan.iter().any(|line| line.starts_with("frozen: 400 particles")), "{plan:?}");
            }
            "[[inflow]]" | "[[stage]]" => {
                let plan = plan(&format!("{base}{block}"));
                assert!(plan.iter().any(|line| line.starts_with("inflow") || line.starts_with("stage")), "{plan:?}");
            }
            // the file of the example is not there
            "[start]" => {
                let error = SceneDescription::from_toml(&format!("{base}{block}")).map(Scene::validate).unwrap();
                assert!(error.unwrap_err().to_string().contains("was not read"));
            }
            other => panic!("{other}: a block that this test does not know"),
        }
        seen.push(first);
    }
    assert_eq!(seen, ["scale", "[[insertion]]", "placement", "[[inflow]]", "[[stage]]", "[start]"]);
}
