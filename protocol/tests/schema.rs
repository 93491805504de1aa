//! The published schema only ever adds. `descriptor.binpb` is the schema as last committed.
//!
//! After an addition: `STURZ_UPDATE_DESCRIPTOR=1 cargo test -p sturz-protocol --test schema`.

use std::collections::BTreeMap;

use prost::Message;
use prost_types::{DescriptorProto, FileDescriptorSet};

const COMMITTED_FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/descriptor.binpb");

/// What must stay as it is: a description of each field, by message and number; each enum value, by enum and number.
fn promises(set: &FileDescriptorSet) -> BTreeMap<(String, i32), String> {
    let mut promises = BTreeMap::new();
    for file in &set.file {
        for message in &file.message_type {
            add_message(file.package(), message, &mut promises);
        }
        for kind in &file.enum_type {
            for value in &kind.value {
                promises.insert((kind.name().into(), value.number()), value.name().into());
            }
        }
    }
    promises
}

fn add_message(scope: &str, message: &DescriptorProto, promises: &mut BTreeMap<(String, i32), String>) {
    let name = format!("{scope}.{}", message.name());
    for field in &message.field {
        let oneof = field.oneof_index.map(|index| message.oneof_decl[index as usize].name());
        let promise =
            format!("{} {:?} {:?} {} {oneof:?}", field.name(), field.r#type(), field.label(), field.type_name());
        promises.insert((name.clone(), field.number()), promise);
    }
    message.nested_type.iter().for_each(|nested| add_message(&name, nested, promises));
}

/// What of `old` is no longer so in `new`.
fn broken(old: &FileDescriptorSet, new: &FileDescriptorSet) -> Vec<String> {
    let new = promises(new);
    let changed = |(place, promise): &((String, i32), String)| new.get(place) != Some(promise);
    let explain = |(place, promise)| format!("{place:?}: was {promise}, is {:?}", new.get(&place));
    promises(old).into_iter().filter(changed).map(explain).collect()
}

#[test]
fn the_schema_only_adds_and_the_committed_set_is_current() {
    let now = FileDescriptorSet::decode(sturz_protocol::DESCRIPTOR_SET).unwrap();
    let update = std::env::var_os("STURZ_UPDATE_DESCRIPTOR").is_some();
    match std::fs::read(COMMITTED_FILE) {
        Ok(bytes) => {
            let committed = FileDescriptorSet::decode(bytes.as_slice()).unwrap();
            assert_eq!(broken(&committed, &now), Vec::<String>::new(), "clients in the field would misread this");
            if committed == now {
                return;
            }
        }
        Err(error) => assert!(update, "{COMMITTED_FILE}: {error}"),
    }
    assert!(update, "the schema grew: run this test with STURZ_UPDATE_DESCRIPTOR=1 and commit descriptor.binpb");
    std::fs::write(COMMITTED_FILE, sturz_protocol::DESCRIPTOR_SET).unwrap();
}

#[test]
fn a_changed_a_renumbered_and_a_removed_field_are_noticed() {
    let now = FileDescriptorSet::decode(sturz_protocol::DESCRIPTOR_SET).unwrap();
    let edits: [fn(&mut DescriptorProto); 3] = [
        |message| message.field[0].number = Some(99),
        |message| message.field[0].set_type(prost_types::field_descriptor_proto::Type::Sint32),
        |message| message.field.clear(),
    ];
    for edit in edits {
        let mut edited = now.clone();
        edit(&mut edited.file[0].message_type[0]);
        assert!(!broken(&now, &edited).is_empty());
    }
    let mut grown = now.clone();
    let mut message = grown.file[0].message_type[0].clone();
    message.name = Some("Another".into());
    grown.file[0].message_type.push(message);
    assert_eq!(broken(&now, &grown), Vec::<String>::new());
}
