//! What all messages have in common: the header, read without the rest.

use std::time::{SystemTime, UNIX_EPOCH};

use prost::Message;
use sturz_protocol::v1;

/// The first field of `Frame`, `FieldFrame`, `Report` and `Event`; all others are skipped.
#[derive(Clone, PartialEq, Message)]
pub struct Headed {
    /// Which state, which message.
    #[prost(message, optional, tag = "1")]
    pub header: Option<v1::Header>,
}

impl Headed {
    /// The header of a message; `None` for bytes that have none, such as `Info`, whose first field is a string.
    pub fn read(payload: &[u8]) -> Option<v1::Header> {
        Self::decode(payload).ok()?.header
    }
}

/// Name of the message under a key below the instance, where the sender does not say it.
pub fn message_of(tail: &str) -> &'static str {
    match tail.split('/').collect::<Vec<_>>()[..] {
        ["info"] => "Info",
        ["features"] => "Features",
        ["plan"] => "Plan",
        ["shapes", _] => "Shapes",
        ["report"] => "Report",
        ["event", _] => "Event",
        ["field", _] => "FieldFrame",
        ["contacts", _] => "ContactFrame",
        _ => "Frame",
    }
}

/// Wall clock, ns since 1970.
pub(super) fn wall_time_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_read_without_the_rest() {
        let header = v1::Header { seq: 7, step: 9, sim_time_s: 0.5, ..Default::default() };
        let event = v1::Event { header: Some(header.clone()), message: "hello".into(), ..Default::default() };
        assert_eq!(Headed::read(&event.encode_to_vec()), Some(header));
        let info = v1::Info { version: "0.1.0".into(), schema_version: 1, ..Default::default() };
        assert_eq!(Headed::read(&info.encode_to_vec()), None);
        assert_eq!(Headed::read(&[0xff; 9]), None);
    }
}
