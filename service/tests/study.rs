//! `sturz study` as a user meets it, on scenes whose errors are known.

mod common;

use common::sturz;
use serde_json::Value;

fn study(arguments: &[&str]) -> Value {
    let output = sturz(&[&["study"], arguments, &["--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Both schemes are of second order (PHYSICS.md A.6); an order from four steps and four phases is within 0.1 of it.
#[test]
fn a_top_shows_second_order_and_the_recommendation_is_confirmed() {
    let svg = std::env::temp_dir().join(format!("sturz-study-{}.svg", std::process::id()));
    let vary = "time_step=x2,x1,x0.5,x0.25,rotation";
    let arguments = ["free-top", "--vary", vary, "--measure", "orientation[0]", "--error", "1e-3", "--plot"];
    let found = study(&[&arguments[..], &[svg.to_str().unwrap()]].concat());
    let orders = found["orders"].as_array().unwrap();
    assert_eq!(orders.len(), 2);
    for order in orders {
        assert!((number(&order["order"]) - 2.0).abs() < 0.1, "{order}");
    }
    let recommended = &found["recommendation"];
    assert_eq!(recommended["confirmed"], true, "{recommended}");
    assert!(number(&recommended["confirmed_error"]) <= 1e-3);
    let points = found["points"].as_array().unwrap();
    assert_eq!(points.len(), 8);
    let place = recommended["point"].as_u64().unwrap() as usize;
    assert!(number(&points[place]["error"]) <= 1e-3);
    assert!(std::fs::read_to_string(&svg).unwrap().starts_with("<svg"));
    std::fs::remove_file(&svg).unwrap();
}

/// A ball that rolls without slip: 5/7 g sin(30 deg). What is left is the overlap, m g cos(30 deg) / k over the radius, in
/// proportion to 1/k whatever the time step.
#[test]
fn the_error_of_a_rolling_ball_is_that_of_its_stiffness() {
    let arguments = ["rolling-sphere", "--vary", "stiffness=x0.25,x1,x4", "--measure", "velocity[0]"];
    let more = ["--reference", "3.5035714285714286,0,0", "--time", "1", "--samples", "1", "--error", "1e-9"];
    let found = study(&[&arguments[..], &more[..]].concat());
    let order = number(&found["orders"][0]["order"]);
    assert_eq!(found["orders"][0]["key"], "stiffness");
    assert!((order + 1.0).abs() < 0.01, "{order}");
    assert!(found["recommendation"].is_null() && found["remarks"].to_string().contains("no setting reaches"));
}

/// Seeds differ, so means have bars; a setting that is refused stays in the table with its reason.
#[test]
fn seeds_give_bars_and_refusals_are_results() {
    let arguments = ["drum-spheres", "--vary", "time_step=x1,1.0", "--measure", "mean_height", "--time", "0.002"];
    let found =
        study(&[&arguments[..], &["--seeds", "--samples", "3", "--reference", "0", "--scale", "0.05"]].concat());
    let points = found["points"].as_array().unwrap();
    assert!(number(&points[0]["error_bar"]) > 0.0 && number(&points[0]["error"]) > 0.0, "{}", points[0]);
    assert!(points[1]["problem"].as_str().unwrap().contains("critical"), "{}", points[1]);
}

#[test]
fn what_cannot_be_studied_is_refused_with_what_is_allowed() {
    let refused = |arguments: &[&str], expected: &str| {
        let output = sturz(&[&["study", "free-top"], arguments].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected), "{said}");
    };
    refused(&["--vary", "speed", "--measure", "velocity[0]"], "keys are time_step");
    refused(&["--vary", "time_step", "--measure", "speed"], "position[ID]");
    refused(&["--vary", "time_step", "--measure", "velocity[0]", "--reference", "exact"], "energy_residual");
    refused(&["--vary", "time_step", "--measure", "velocity[0]", "--reference", "1,2"], "has 3");
    refused(&["--vary", "time_step", "--measure", "velocity[0]", "--average-from", "30"], "--average-from");
    refused(&["--vary", "time_step", "--measure", "velocity[0]", "--seeds", "--samples", "1"], "--samples of 2");
}
