//! What each role may do, in the words of zenoh's access control. What is not here is denied, to everybody.
//!
//! Messages are listed as they come in from a client; what goes out to one is let through, since it has asked for it by a
//! question or a subscription that was let in.

use serde_json::{Value, json};
use sturz_protocol::keys::{ALL_ALIVE, InvalidName, Keys, Verb};

use super::Role;
use super::folder::Roles;

/// The least role that may give a command.
pub fn role_for(verb: Verb) -> Role {
    match verb {
        Verb::Insert
        | Verb::Remove
        | Verb::SetGravity
        | Verb::SetMotion
        | Verb::SetLoads
        | Verb::SetFluid
        | Verb::Pause
        | Verb::Resume
        | Verb::Step
        | Verb::Advance
        | Verb::DefineField
        | Verb::DropField
        | Verb::DefineOutput
        | Verb::Checkpoint
        | Verb::Restore
        | Verb::ListCheckpoints
        | Verb::DropCheckpoint
        | Verb::AcquireLease
        | Verb::ReleaseLease => Role::Steer,
        Verb::Stop => Role::Admin,
    }
}

/// Zenoh's `access_control` of an instance: denied by default, and allowed what the roles say.
pub fn control(instance: &str, roles: &Roles) -> Result<Value, InvalidName> {
    let keys = Keys::new(instance)?;
    let ids = |role: Role| rules(&keys, role).iter().map(|rule| rule["id"].clone()).collect::<Vec<_>>();
    let mut all_rules: Vec<Value> = Role::ALL.into_iter().flat_map(|role| rules(&keys, role)).collect();
    all_rules.push(outgoing(&keys));
    let (mut subjects, mut policies) = (Vec::new(), Vec::new());
    for role in Role::ALL {
        let names: Vec<&String> = roles.iter().filter(|&(_, &has)| has == role).map(|(name, _)| name).collect();
        // A subject without names would be everybody.
        if names.is_empty() {
            continue;
        }
        let allowed = Role::ALL.into_iter().filter(|&lesser| lesser <= role).flat_map(ids);
        let allowed: Vec<Value> = allowed.chain([json!("outgoing")]).collect();
        subjects.push(json!({ "id": role.name(), "cert_common_names": names, "link_protocols": ["tls"] }));
        policies.push(json!({ "id": role.name(), "rules": allowed, "subjects": [role.name()] }));
    }
    Ok(json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": all_rules,
        "subjects": subjects,
        "policies": policies,
    }))
}

/// What this role may do that lesser ones may not.
fn rules(keys: &Keys, role: Role) -> Vec<Value> {
    let incoming = |what: &str, messages: &[&str], keys: Vec<String>| {
        json!({
            "id": format!("{role}-{what}"),
            "messages": messages,
            "flows": ["ingress"],
            "permission": "allow",
            "key_exprs": keys,
        })
    };
    let commands: Vec<String> =
        Verb::ALL.into_iter().filter(|&verb| role_for(verb) == role).map(|verb| keys.command(verb)).collect();
    match role {
        Role::View => vec![
            incoming("questions", &["query"], [questions(keys), vec![past_events(keys)]].concat()),
            incoming("streams", &["declare_subscriber"], [streams(keys), vec![past_events(keys)]].concat()),
            incoming(
                "liveliness",
                &["declare_liveliness_subscriber", "liveliness_query"],
                vec![keys.alive(), ALL_ALIVE.into(), past_events(keys)],
            ),
        ],
        Role::Steer => vec![
            incoming("commands", &["query", "put"], commands),
            incoming("liveliness", &["liveliness_token"], vec![keys.all_clients()]),
        ],
        Role::Admin => vec![incoming("commands", &["query", "put"], commands)],
    }
}

/// Everything that the daemon says.
fn outgoing(keys: &Keys) -> Value {
    json!({
        "id": "outgoing",
        "messages": ["put", "delete", "reply", "liveliness_token"],
        "flows": ["egress"],
        "permission": "allow",
        "key_exprs": [format!("sturz/v1/{}/**", keys.instance()), past_events(keys)],
    })
}

/// Keys that answer a question.
fn questions(keys: &Keys) -> Vec<String> {
    vec![
        keys.info(),
        keys.features(),
        keys.plan(),
        keys.all_shapes(),
        keys.report_latest(),
        keys.state_latest(),
        keys.contacts_latest(),
        keys.exchange_latest(),
        keys.all_fields_latest(),
    ]
}

/// Keys that are published.
fn streams(keys: &Keys) -> Vec<String> {
    vec![keys.state_frame(), keys.contacts_frame(), keys.field("*"), keys.report(), keys.all_events()]
}

/// Where zenoh's advanced publishers keep the past; `**` does not include it.
fn past_events(keys: &Keys) -> String {
    format!("{}/@adv/**", keys.all_events())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roles(list: &[(&str, Role)]) -> Roles {
        list.iter().map(|&(name, role)| (name.to_string(), role)).collect()
    }

    #[test]
    fn only_an_admin_may_end_the_daemon_and_a_viewer_gives_no_command() {
        let control = control("a", &roles(&[("eve", Role::View), ("bob", Role::Admin), ("al", Role::Steer)])).unwrap();
        let rules: Vec<&Value> = control["rules"].as_array().unwrap().iter().collect();
        let ids_with = |key: &str| -> Vec<&str> {
            let has = |rule: &&&Value| rule["key_exprs"].as_array().unwrap().iter().any(|each| each == key);
            rules.iter().filter(has).map(|rule| rule["id"].as_str().unwrap()).collect()
        };
        assert_eq!(ids_with("sturz/v1/a/cmd/stop"), ["admin-commands"]);
        assert_eq!(ids_with("sturz/v1/a/cmd/step"), ["steer-commands"]);
        let policy = |role: &str| {
            let all = control["policies"].as_array().unwrap();
            all.iter().find(|policy| policy["id"] == role).unwrap()["rules"].to_string()
        };
        assert!(!policy("view").contains("commands"));
        assert!(policy("steer").contains("steer-commands") && !policy("steer").contains("admin-commands"));
        assert!(policy("admin").contains("steer-commands") && policy("admin").contains("admin-commands"));
        assert_eq!(control["default_permission"], "deny");
    }

    #[test]
    fn a_role_that_nobody_has_is_nobodys() {
        let control = control("a", &roles(&[("eve", Role::View)])).unwrap();
        assert_eq!(control["subjects"].as_array().unwrap().len(), 1);
        assert_eq!(control["subjects"][0]["cert_common_names"], json!(["eve"]));
        assert_eq!(control["policies"].as_array().unwrap().len(), 1);
    }
}
