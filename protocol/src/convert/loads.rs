//! Loads from the wire.

use sturz_engine::{InvalidInput, LoadDescription};

use crate::columns::{self, Number};
use crate::v1;

/// Loads of `set_loads` and `advance`, under `path` in the request. Values are the engine's to check.
pub fn loads_from_wire(loads: &v1::Loads, path: &str) -> Result<LoadDescription, InvalidInput> {
    let vectors = |name: &str, column: &Option<v1::Column>| rows::<f64, 3>(column, path, name);
    let numbers = |name: &str, column: &Option<v1::Column>| flat::<f64>(column, path, name);
    Ok(LoadDescription {
        topology_epoch: loads.topology_epoch,
        ids: flat(&loads.ids, path, "ids")?,
        force_n: vectors("force_n", &loads.force_n)?,
        torque_n_m: vectors("torque_n_m", &loads.torque_n_m)?,
        drag_n_s_per_m: numbers("drag_n_s_per_m", &loads.drag_n_s_per_m)?,
        fluid_velocity_m_per_s: vectors("fluid_velocity_m_per_s", &loads.fluid_velocity_m_per_s)?,
        rotational_drag_n_m_s: numbers("rotational_drag_n_m_s", &loads.rotational_drag_n_m_s)?,
        fluid_angular_velocity_rad_per_s: vectors(
            "fluid_angular_velocity_rad_per_s",
            &loads.fluid_angular_velocity_rad_per_s,
        )?,
        ramp_s: loads.ramp_s,
        valid_until_s: loads.valid_until_s,
    })
}

/// None when it was left out.
pub(super) fn rows<T: Number, const C: usize>(
    column: &Option<v1::Column>,
    path: &str,
    name: &str,
) -> Result<Vec<[T; C]>, InvalidInput> {
    let Some(column) = column else { return Ok(Vec::new()) };
    columns::read(column).map_err(|error| InvalidInput::new(format!("{path}.{name}"), error.to_string()))
}

pub(super) fn flat<T: Number>(column: &Option<v1::Column>, path: &str, name: &str) -> Result<Vec<T>, InvalidInput> {
    Ok(rows::<T, 1>(column, path, name)?.into_flattened())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_of_another_kind_is_named() {
        let ids = Some(columns::flat("ids", "", 1, &[1u64, 2]));
        let force_n = Some(columns::flat("force_n", "N", 1, &[1.0, 2.0]));
        let wrong =
            loads_from_wire(&v1::Loads { ids: ids.clone(), force_n, ..Default::default() }, "loads").unwrap_err();
        assert_eq!(wrong.path, "loads.force_n");
        assert!(wrong.problem.contains("needs 3"), "{wrong}");
        let right = loads_from_wire(&v1::Loads { ids, topology_epoch: 3, ..Default::default() }, "loads").unwrap();
        assert_eq!((right.ids, right.topology_epoch), (vec![1, 2], 3));
    }
}
