//! `run.mcap`: the series as JSON channels and the particles as `foxglove.PointCloud`.
//!
//! Log time is simulated time in nanoseconds. Topics: `/<table>/<name>`, `/diagnostics` and
//! `/particles`; the resolved case is an attachment.

use super::OutputError;
use super::rows::Row;
use crate::simulation::FramePoint;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{PackedElementField, PointCloud, Pose, Quaternion, Timestamp, Vector3};
use foxglove::{Encode, bytes::Bytes};
use mcap::records::MessageHeader;
use mcap::{Attachment, WriteOptions, Writer};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::{Duration, Instant};

/// At most this much wall time of a run that is killed is missing from the recording.
const FLUSH_AFTER: Duration = Duration::from_millis(500);

/// Fields of a particle in a frame, 32-bit floats each.
const FRAME_FIELDS: [&str; 5] = ["x", "y", "u", "v", "p"];

/// An open recording.
pub(super) struct Recording {
    writer: Writer<BufWriter<File>>,
    /// Channel and messages so far of each topic.
    channels: HashMap<String, (u16, u32)>,
    flushed: Instant,
}

impl Recording {
    /// Creates `path` with the case file `case` attached.
    pub(super) fn create(path: &Path, case: &str) -> Result<Self, OutputError> {
        let file = File::create(path).map_err(OutputError::at(path))?;
        let options = WriteOptions::new()
            .compression(None)
            .library(concat!("seakeep ", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(BufWriter::new(file))?;
        writer.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: "resolved.toml".to_owned(),
            media_type: "application/toml".to_owned(),
            data: Cow::Borrowed(case.as_bytes()),
        })?;
        let mut recording = Self { writer, channels: HashMap::new(), flushed: Instant::now() };
        recording.flush()?;
        Ok(recording)
    }

    /// Adds a row of a table.
    pub(super) fn row<R: Row>(&mut self, time: f64, row: &R) -> Result<(), OutputError> {
        let topic = match row.name() {
            "" => format!("/{}", R::TABLE),
            name => format!("/{}/{name}", R::TABLE),
        };
        let data =
            serde_json::to_vec(row).map_err(std::io::Error::from).map_err(mcap::McapError::from)?;
        self.message(&topic, time, &data, |writer, topic| {
            let name = format!("seakeep.{}", R::TABLE);
            let schema = writer.add_schema(&name, "jsonschema", json_schema::<R>().as_bytes())?;
            writer.add_channel(schema, topic, "json", &BTreeMap::new())
        })
    }

    /// Adds a frame of particles.
    pub(super) fn frame(&mut self, time: f64, points: &[FramePoint]) -> Result<(), OutputError> {
        let mut data = Vec::with_capacity(size_of_val(points));
        for value in points.iter().flatten() {
            data.extend_from_slice(&value.to_le_bytes());
        }
        let nanoseconds = nanoseconds(time);
        let field = |(index, name): (usize, &&str)| PackedElementField {
            name: (*name).to_owned(),
            offset: (index * size_of::<f32>()) as u32,
            r#type: NumericType::Float32 as i32,
        };
        let cloud = PointCloud {
            timestamp: Some(Timestamp::new(
                (nanoseconds / 1_000_000_000) as u32,
                (nanoseconds % 1_000_000_000) as u32,
            )),
            frame_id: "tank".to_owned(),
            pose: Some(Pose {
                position: Some(Vector3 { x: 0.0, y: 0.0, z: 0.0 }),
                orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
            }),
            point_stride: size_of::<FramePoint>() as u32,
            fields: FRAME_FIELDS.iter().enumerate().map(field).collect(),
            data: Bytes::from(data),
        };
        let mut message = Vec::with_capacity(cloud.encoded_len().unwrap_or_default());
        cloud
            .encode(&mut message)
            .map_err(|error| mcap::McapError::from(std::io::Error::other(error)))?;
        self.message("/particles", time, &message, |writer, topic| {
            let schema = match PointCloud::get_schema() {
                Some(schema) => writer.add_schema(&schema.name, &schema.encoding, &schema.data)?,
                None => 0,
            };
            let encoding = PointCloud::get_message_encoding();
            writer.add_channel(schema, topic, &encoding, &BTreeMap::new())
        })
    }

    /// Adds a message to a topic, which `open` opens the first time.
    fn message(
        &mut self,
        topic: &str,
        time: f64,
        data: &[u8],
        open: impl FnOnce(&mut Writer<BufWriter<File>>, &str) -> mcap::McapResult<u16>,
    ) -> Result<(), OutputError> {
        if !self.channels.contains_key(topic) {
            let channel = open(&mut self.writer, topic)?;
            self.channels.insert(topic.to_owned(), (channel, 0));
        }
        let Some((channel_id, count)) = self.channels.get_mut(topic) else { return Ok(()) };
        let log_time = nanoseconds(time);
        let header = MessageHeader {
            channel_id: *channel_id,
            sequence: *count,
            log_time,
            publish_time: log_time,
        };
        *count += 1;
        self.writer.write_to_known_channel(&header, data)?;
        if self.flushed.elapsed() > FLUSH_AFTER {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        self.writer.flush()?;
        self.flushed = Instant::now();
        Ok(())
    }

    /// Writes the index and closes the file.
    pub(super) fn finish(mut self) -> Result<(), OutputError> {
        self.writer.finish()?;
        Ok(())
    }
}

fn nanoseconds(time: f64) -> u64 {
    (time * 1e9).round() as u64
}

/// The JSON schema of a row: a flat object of numbers, with the one column that is a name.
fn json_schema<R: Row>() -> String {
    let kind = |column: &str| if Some(column) == R::NAMED_BY { "string" } else { "number" };
    let properties: serde_json::Map<String, serde_json::Value> = R::COLUMNS
        .iter()
        .map(|column| ((*column).to_owned(), serde_json::json!({ "type": kind(column) })))
        .collect();
    serde_json::json!({ "type": "object", "properties": properties }).to_string()
}
