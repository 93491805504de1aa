//! What a scene does of its own accord: stages and inflows, told as events.

use sturz_engine::Happening;
use sturz_engine::scene::SceneDescription;
use sturz_protocol::v1;

use crate::runner::Runner;

/// An event, without header, that tells of it.
pub fn event(scene: &SceneDescription, happening: &Happening) -> v1::Event {
    let inflow = |index: usize| scene.inflows.get(index);
    let title = |index: usize| inflow(index).map_or_else(|| format!("inflow {index}"), |inflow| inflow.title(index));
    let inflow_name = |index: usize| inflow(index).map(|inflow| inflow.name.clone()).unwrap_or_default();
    let (kind, name, message) = match happening {
        Happening::StageBegan { index, name } => {
            let title = scene.stages.get(*index).map_or_else(|| format!("stage {index}"), |stage| stage.title(*index));
            (v1::EventKind::Stage, name.clone(), format!("{title} begins"))
        }
        Happening::StagesOver => {
            (v1::EventKind::Stage, String::new(), "the last stage is over: the scene's own laws hold".into())
        }
        Happening::Inflow { index, count, .. } => {
            (v1::EventKind::Particles, inflow_name(*index), format!("{count} particles came in by {}", title(*index)))
        }
        Happening::InflowShort { index, total } => {
            let text = format!(
                "{} finds no room for all that is due, in {total} batches so far: they come with a later one",
                title(*index)
            );
            (v1::EventKind::Inflow, inflow_name(*index), text)
        }
        Happening::InflowOver { index, count } => {
            let text = format!("{} is over: {count} particles came in", title(*index));
            (v1::EventKind::Inflow, inflow_name(*index), text)
        }
    };
    let severity = match happening {
        Happening::InflowShort { .. } => v1::Severity::Warning,
        _ => v1::Severity::Info,
    };
    let inserted = match *happening {
        Happening::Inflow { first_id, count, .. } => Some(v1::IdRange { first_id, count }),
        _ => None,
    };
    v1::Event { kind: kind.into(), severity: severity.into(), message, name, inserted, ..v1::Event::default() }
}

impl Runner<'_> {
    /// After a step: tells of what the scene has done besides it.
    pub(crate) fn tell_happenings(&mut self) {
        if !self.engine.has_happenings() {
            return;
        }
        for happening in self.engine.take_happenings() {
            let event = event(self.engine.scene().description(), &happening);
            if matches!(happening, Happening::StageBegan { .. } | Happening::StagesOver) {
                tracing::info!("step {}: {}", self.moment().step, event.message);
            }
            self.announce_event(event);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_name_what_the_scene_names() {
        let scene = SceneDescription::from_toml(
            "[scene]\nname = \"s\"\n[[stage]]\nname = \"squeeze\"\n[[inflow]]\nshape = \"a\"\nmaterial = \"b\"\ninterval_s = 1.0\n\
             region = { kind = \"box\", min_m = [0.0, 0.0, 0.0], max_m = [1.0, 1.0, 1.0] }\n",
        )
        .unwrap();
        let told = event(&scene, &Happening::StageBegan { index: 0, name: "squeeze".into() });
        assert_eq!((told.kind(), told.name.as_str()), (v1::EventKind::Stage, "squeeze"));
        assert_eq!(told.message, "stage 'squeeze' begins");
        let told = event(&scene, &Happening::Inflow { index: 0, first_id: 7, count: 3 });
        assert_eq!(
            (told.kind(), told.inserted),
            (v1::EventKind::Particles, Some(v1::IdRange { first_id: 7, count: 3 }))
        );
        assert_eq!(told.message, "3 particles came in by inflow 0");
        let told = event(&scene, &Happening::InflowShort { index: 0, total: 2 });
        assert_eq!((told.kind(), told.severity()), (v1::EventKind::Inflow, v1::Severity::Warning));
    }
}
