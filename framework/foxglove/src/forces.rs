//! The forces of a contact as a typed message.
#![allow(non_snake_case)]

use foxglove::{Encode, Schema, messages};
use nalgebra::Vector3;
use prost::Message;
use prost_types::{
    DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet,
    field_descriptor_proto::{Label, Type},
};

use wbqp::{contact::SurfaceMotion, controller::ContactReport};
use wbqp_log::TrueContact;

use crate::convert::{timestamp, vector};

/// The forces of the environment on the robot at one contact, `wbqp.ContactForces`; world axes.
#[derive(Clone, PartialEq, prost::Message)]
pub struct ContactForces {
    /// Time of the measurement.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<prost_types::Timestamp>,
    /// Name of the world's frame.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// Whether the contact is switched on.
    #[prost(bool, tag = "3")]
    pub active: bool,
    /// Ramp, 0 off to 1 on.
    #[prost(double, tag = "4")]
    pub alpha: f64,
    /// Friction coefficient that the controller assumes.
    #[prost(double, tag = "5")]
    pub friction: f64,
    /// Contact point, m.
    #[prost(message, optional, tag = "6")]
    pub position: Option<messages::Vector3>,
    /// Outward normal of the surface.
    #[prost(message, optional, tag = "7")]
    pub normal: Option<messages::Vector3>,
    /// What the solver plans, N.
    #[prost(message, optional, tag = "8")]
    pub planned: Option<messages::Vector3>,
    /// What the sensor says, N.
    #[prost(message, optional, tag = "9")]
    pub measured: Option<messages::Vector3>,
    /// The real force, N; absent outside simulation.
    #[prost(message, optional, tag = "10")]
    pub truth: Option<messages::Vector3>,
}

impl ContactForces {
    /// Those of one contact at `time`, s.
    pub(crate) fn of(
        time: f64,
        (contact, surface): (&ContactReport, &SurfaceMotion),
        truth: Option<TrueContact>,
        world: &str,
    ) -> Self {
        let R_WC = surface.R_WC;
        let stamp = timestamp(time);
        Self {
            timestamp: Some(prost_types::Timestamp {
                seconds: i64::from(stamp.sec()),
                nanos: i32::try_from(stamp.nsec()).unwrap_or_default(),
            }),
            frame_id: world.to_owned(),
            active: contact.on,
            alpha: contact.alpha,
            friction: contact.friction,
            position: Some(vector(&(surface.p_WS + R_WC * contact.position))),
            normal: Some(vector(&(R_WC * Vector3::z()))),
            planned: Some(vector(&(R_WC * contact.solution.fixed_rows::<3>(0)))),
            measured: Some(vector(&(R_WC * contact.measured.fixed_rows::<3>(0)))),
            truth: truth.map(|truth| vector(&(R_WC * truth.force))),
        }
    }

    /// The type's full name.
    pub const NAME: &str = "wbqp.ContactForces";

    /// A serialized `FileDescriptorSet` of this type and all that it uses.
    pub fn descriptors() -> Vec<u8> {
        let mut files = Vec::new();
        // Foxglove's schemas bring the files that they use, Google's timestamps among them.
        for schema in [
            messages::Vector3::get_schema(),
            messages::PoseInFrame::get_schema(),
        ] {
            let Some(Schema { data, .. }) = schema else {
                continue;
            };
            let set = FileDescriptorSet::decode(&*data).unwrap_or_default();
            files.extend(set.file);
        }
        let used = ["google/protobuf/timestamp.proto", "foxglove/Vector3.proto"];
        let is_used = |file: &FileDescriptorProto| used.contains(&file.name());
        files.retain(is_used);
        files.sort_by(|a, b| a.name.cmp(&b.name));
        files.dedup_by(|a, b| a.name == b.name);
        let dependency = files.iter().filter_map(|file| file.name.clone()).collect();
        files.push(FileDescriptorProto {
            name: Some("wbqp/ContactForces.proto".to_owned()),
            package: Some("wbqp".to_owned()),
            dependency,
            message_type: vec![message_type()],
            syntax: Some("proto3".to_owned()),
            ..FileDescriptorProto::default()
        });
        FileDescriptorSet { file: files }.encode_to_vec()
    }
}

/// Same tags as the derived encoding.
fn message_type() -> DescriptorProto {
    let vector = Some(".foxglove.Vector3");
    let fields = [
        (
            "timestamp",
            Type::Message,
            Some(".google.protobuf.Timestamp"),
        ),
        ("frame_id", Type::String, None),
        ("active", Type::Bool, None),
        ("alpha", Type::Double, None),
        ("friction", Type::Double, None),
        ("position", Type::Message, vector),
        ("normal", Type::Message, vector),
        ("planned", Type::Message, vector),
        ("measured", Type::Message, vector),
        ("truth", Type::Message, vector),
    ];
    let field = fields
        .into_iter()
        .zip(1..)
        .map(|((name, kind, type_name), tag)| FieldDescriptorProto {
            name: Some(name.to_owned()),
            number: Some(tag),
            label: Some(Label::Optional.into()),
            r#type: Some(kind.into()),
            type_name: type_name.map(str::to_owned),
            json_name: Some(name.to_owned()),
            ..FieldDescriptorProto::default()
        });
    DescriptorProto {
        name: Some("ContactForces".to_owned()),
        field: field.collect(),
        ..DescriptorProto::default()
    }
}
