//! Steers a running simulation: `sturz serve drum-crosses`, then `cargo run --example steer`.

use std::time::Duration;

use sturz_client::v1::{FieldQuantity, boundary_info::Geometry};
use sturz_client::{Amount, DEFAULT_ENDPOINT, FieldDefinition, Insertion, Placement, Region, Simulation, Window};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let simulation = Simulation::connect("drum-crosses", DEFAULT_ENDPOINT, Duration::from_secs(5))?;
    simulation.pause()?;

    let info = simulation.info()?;
    let drums = info.boundaries.iter().filter_map(|boundary| match &boundary.geometry {
        Some(Geometry::CylinderInside(drum)) => Some(drum.radius_m),
        _ => None,
    });
    // Within any drum around the origin, whatever its axis.
    let half = drums.fold(f64::INFINITY, f64::min) / 2.0;
    let region = Region::Box { min_m: [-half; 3], max_m: [half; 3] };
    let placement = Placement::random(region, Amount::Count(20));
    let inserted = simulation.insert(Insertion::new(&info.shapes[0], &info.materials[0], placement))?;
    println!("inserted particles {:?}", inserted.ids);

    simulation.define_field(FieldDefinition {
        name: "middle".into(),
        min_m: [-half; 3],
        max_m: [half; 3],
        cells: [4, 1, 4],
        quantities: vec![FieldQuantity::SolidFraction, FieldQuantity::Velocity],
        width_m: half / 4.0,
        ..Default::default()
    })?;
    for _ in 0..5 {
        let advanced = simulation.advance(Window::new(0.01).with_fields(["middle"]))?;
        let field = &advanced.fields[0];
        println!("t = {:.3} s, {} steps", advanced.time_reached_s, advanced.steps_done);
        let samples = field.centres_m().into_iter().zip(field.scalars("solid_fraction")?);
        for ([x, _, z], fraction) in samples {
            println!("  x = {x:+.4} m, z = {z:+.4} m: solid fraction {fraction:.3}");
        }
    }
    Ok(())
}
