//! A live view, seen by a client that knows Foxglove's protocol and nothing else of this library.

use std::{
    collections::BTreeMap,
    net::TcpStream,
    path::Path,
    time::{Duration, Instant},
};

use tungstenite::{ClientRequestBuilder, Message, WebSocket, http::Uri, stream::MaybeTlsStream};
use wbqp::{
    Controller, ControllerConfig, Measurement,
    serde_json::{self, Value, json},
};
use wbqp_foxglove::{LiveError, LiveView};

use {wbqp_robots as _, wbqp_tasks as _};

const CONFIG: &str = r#"
[controller]
rate = 250.0

[robot]
type = "othex"

[[contact]]
name = "tip"
frame = "tool"
kind = "point"
surface = { normal = [-1.0, 0.0, 0.0], x_axis = [0.0, 0.0, 1.0] }
active = false

[[task]]
name = "base_position"
type = "base_position"
weight = 1.0
kp = 9.0
kd = 10.4
reference = { type = "hold", value = [0.0, 0.0, 1.0] }

[[task]]
name = "base_orientation"
type = "base_orientation"
weight = [1.0, 2.0, 3.0]
kp = 47.6
kd = 10.0
reference = { type = "hold", value = [0.0, 0.0, 0.0] }

[[task]]
name = "posture"
type = "posture"
weight = 0.1
kp = 12.0
kd = 9.0
reference = { type = "hold", value = [0.0, 0.26, 0.96] }
"#;

fn controller() -> Controller {
    let config = ControllerConfig::from_str(CONFIG, "live.toml", Path::new(".")).expect("is read");
    Controller::new(config).expect("is made")
}

/// A controller in a loop, and a client.
struct Loop {
    controller: Controller,
    measurement: Measurement,
    view: LiveView,
    client: WebSocket<MaybeTlsStream<TcpStream>>,
    /// Channels that the server has, by topic.
    channels: BTreeMap<String, Value>,
    /// Other texts that came.
    texts: Vec<Value>,
    /// Subscription and contents.
    data: Vec<(u32, Vec<u8>)>,
}

impl Loop {
    fn new() -> Self {
        let controller = controller();
        let view = LiveView::on_port(&controller, 0).expect("a port is free");
        Self::of(controller, view)
    }

    fn of(controller: Controller, view: LiveView) -> Self {
        let address = format!("ws://127.0.0.1:{}", view.port());
        let address: Uri = address.parse().expect("is an address");
        let request = ClientRequestBuilder::new(address).with_sub_protocol("foxglove.sdk.v1");
        let (client, answer) = tungstenite::connect(request).expect("connects");
        let protocol = answer.headers().get("sec-websocket-protocol");
        assert_eq!(
            protocol.and_then(|p| p.to_str().ok()),
            Some("foxglove.sdk.v1")
        );
        if let MaybeTlsStream::Plain(stream) = client.get_ref() {
            let patience = Some(Duration::from_millis(2));
            stream.set_read_timeout(patience).expect("can be set");
        }
        Self {
            measurement: controller.measurement(),
            controller,
            view,
            client,
            channels: BTreeMap::new(),
            texts: Vec::new(),
            data: Vec::new(),
        }
    }

    /// Ticks and listens until there is what is looked for; at most ten seconds.
    fn until<T>(&mut self, what: &str, found: impl Fn(&Self) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(found) = found(self) {
                return found;
            }
            assert!(
                start.elapsed() < Duration::from_secs(10),
                "{what}: {:?}",
                self.texts
            );
            self.measurement.time += 0.004;
            self.controller.tick(&self.measurement);
            self.view.update(&mut self.controller, &self.measurement);
            self.listen();
        }
    }

    fn listen(&mut self) {
        match self.client.read() {
            Ok(Message::Text(text)) => {
                let value: Value = serde_json::from_str(&text).expect("is JSON");
                if value["op"] == "advertise" {
                    for channel in value["channels"].as_array().expect("is a list") {
                        let topic = channel["topic"].as_str().expect("is a text");
                        self.channels.insert(topic.to_owned(), channel.clone());
                    }
                }
                self.texts.push(value);
            }
            Ok(Message::Binary(bytes)) if bytes.first() == Some(&1) => {
                let id = bytes[1..5].try_into().expect("four bytes");
                self.data
                    .push((u32::from_le_bytes(id), bytes[13..].to_vec()));
            }
            Ok(_) => {}
            Err(tungstenite::Error::Io(error))
                if matches!(
                    error.kind(),
                    std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut
                ) => {}
            Err(error) => panic!("the connection is lost: {error}"),
        }
    }

    fn say(&mut self, what: &Value) {
        let text = Message::text(what.to_string());
        self.client.send(text).expect("is sent");
    }

    /// Sets a parameter and waits for the server's word on it.
    fn set(&mut self, name: &str, value: &Value) -> Value {
        self.texts.clear();
        self.say(&json!({
            "op": "setParameters", "id": "set",
            "parameters": [{ "name": name, "value": value }],
        }));
        self.until("parameters", |this| {
            let said = this
                .texts
                .iter()
                .find(|text| text["op"] == "parameterValues")?;
            Some(said["parameters"].clone())
        })
    }

    /// What is told to all clients.
    fn status(&mut self) -> String {
        self.until("a status", |this| {
            let status = this.texts.iter().find(|text| text["op"] == "status")?;
            status["message"].as_str().map(str::to_owned)
        })
    }

    fn kp(&self) -> Option<f64> {
        let keys = self.controller.parameters("base_position").ok()?;
        keys.get("kp")?.as_float()
    }
}

#[test]
fn topics_are_served() {
    let mut run = Loop::new();
    let names = [
        "/state",
        "/tf",
        "/scene",
        "/scene/robot",
        "/contact/tip/forces",
        "/view",
    ];
    run.until("topics", |this| {
        names
            .iter()
            .all(|name| this.channels.contains_key(*name))
            .then_some(())
    });
    assert_eq!(run.channels["/tf"]["encoding"], "protobuf");
    assert_eq!(
        run.channels["/tf"]["schemaName"],
        "foxglove.FrameTransforms"
    );
    assert_eq!(run.channels["/state"]["encoding"], "json");
    let channels = ["/state", "/tf", "/scene/robot"].map(|name| run.channels[name]["id"].clone());
    let [state, tf, robot] = channels;
    run.say(&json!({
        "op": "subscribe",
        "subscriptions": [
            { "id": 1, "channelId": state }, { "id": 2, "channelId": tf }, { "id": 3, "channelId": robot },
        ],
    }));
    for id in [1, 2, 3] {
        run.until("messages", |this| {
            this.data.iter().find(|(of, _)| *of == id).map(|_| ())
        });
    }
    let state = run.data.iter().find(|(id, _)| *id == 1).expect("came");
    let state: Value = serde_json::from_slice(&state.1).expect("is JSON");
    assert!(state["base"]["position"]["z"].is_number());
}

#[test]
fn parameters_take_effect_between_ticks() {
    let mut run = Loop::new();
    // What is followed is known once a tick was shown.
    run.until("topics", |this| {
        this.channels.contains_key("/view").then_some(())
    });
    let state = run.channels["/state"]["id"].clone();
    run.say(&json!({ "op": "subscribe", "subscriptions": [{ "id": 1, "channelId": state }] }));
    run.until("a tick", |this| this.data.first().map(|_| ()));
    run.texts.clear();
    run.say(&json!({ "op": "getParameters", "parameterNames": [], "id": "all" }));
    let all = run.until("parameters", |this| {
        let said = this
            .texts
            .iter()
            .find(|text| text["op"] == "parameterValues")?;
        Some(said["parameters"].clone())
    });
    let all: BTreeMap<&str, &Value> = all
        .as_array()
        .expect("is a list")
        .iter()
        .filter_map(|p| Some((p["name"].as_str()?, &p["value"])))
        .collect();
    assert_eq!(all["base_position.kp"], &json!(9.0));
    assert_eq!(all["base_position.weight"], &json!(1.0));
    assert_eq!(all["base_orientation.weight"], &json!([1.0, 2.0, 3.0]));
    assert_eq!(all["posture.active"], &json!(true));
    assert_eq!(all["contact.tip.active"], &json!(false));
    assert_eq!(all["base_position.reference"], &json!([0.0, 0.0, 1.0]));

    assert_eq!(
        run.set("base_position.kp", &json!(12))[0]["value"],
        json!(12.0)
    );
    run.until("kp", |this| (this.kp() == Some(12.0)).then_some(()));
    run.set("base_orientation.weight", &json!([2.0, 2.0, 4.0]));
    let weight = |this: &Loop, of: &str| this.controller.weight(of).ok().map(<[f64]>::to_vec);
    run.until("weights", |this| {
        (weight(this, "base_orientation") == Some(vec![2.0, 2.0, 4.0])).then_some(())
    });
    run.set("posture.active", &json!(false));
    run.until("switch", |this| {
        let is_on = this.controller.is_on("posture");
        (is_on == Ok(false)).then_some(())
    });
    run.set("contact.tip.active", &json!(true));
    run.until("contact", |this| {
        this.controller.is_contact_on("tip").ok().filter(|on| *on)
    });
    run.say(&json!({
        "op": "subscribeParameterUpdates", "parameterNames": ["base_position.reference"],
    }));
    run.set("base_position.reference", &json!([0.1, 0.0, 1.1]));
    run.texts.clear();
    // What all clients hear is what was asked for, not what was followed before.
    let said = run.until("news", |this| {
        let mut said = this.texts.iter();
        let said = said.find(|text| text["op"] == "parameterValues")?;
        Some(said["parameters"][0]["value"].clone())
    });
    assert_eq!(said, json!([0.1, 0.0, 1.1]));
    run.until("reference", |this| {
        match this.controller.followed("base_position") {
            Ok(wbqp::plugin::Sample::Vector(at)) => (at.value == [0.1, 0.0, 1.1]).then_some(()),
            _ => None,
        }
    });
}

#[test]
fn what_is_refused_is_told_and_set_back() {
    let mut run = Loop::new();
    // Not a number at all: refused before the loop hears of it.
    assert_eq!(
        run.set("base_position.kp", &json!("much"))[0]["value"],
        json!(9.0)
    );
    assert!(run.status().contains("must be a finite number"));
    // A number that the task refuses.
    run.say(&json!({
        "op": "subscribeParameterUpdates", "parameterNames": ["base_position.kp"],
    }));
    run.set("base_position.kp", &json!(-1.0));
    assert!(run.status().contains("`base_position.kp` is not changed"));
    run.until("the old value", |this| {
        let mut said = this
            .texts
            .iter()
            .rev()
            .filter(|text| text["op"] == "parameterValues");
        said.next()
            .filter(|text| text["parameters"][0]["value"] == json!(9.0))
            .map(|_| ())
    });
    assert_eq!(run.kp(), Some(9.0));
    // The key's table was set back as well: another key of the entry is changed alone.
    run.set("base_position.kd", &json!(8.0));
    run.until("kd", |this| {
        let keys = this.controller.parameters("base_position").ok()?;
        (keys.get("kd")?.as_float() == Some(8.0)).then_some(())
    });
    assert_eq!(run.kp(), Some(9.0));
    run.set("nobody.kp", &json!(1.0));
    assert!(run.status().contains("there is no parameter `nobody.kp`"));
}

#[test]
fn a_client_that_does_not_read_does_not_keep_the_program() {
    let mut run = Loop::new();
    let view = run.channels.clone();
    assert!(view.is_empty(), "nothing was read yet");
    let all = (1..30).map(|id| json!({ "id": id, "channelId": id }));
    run.say(&json!({ "op": "subscribe", "subscriptions": all.collect::<Vec<_>>() }));
    for _ in 0..20_000 {
        run.measurement.time += 0.004;
        run.controller.tick(&run.measurement);
        run.view.update(&mut run.controller, &run.measurement);
    }
    let Loop { view, client, .. } = run;
    let start = Instant::now();
    drop(view);
    assert!(
        start.elapsed() < Duration::from_secs(2),
        "{:?}",
        start.elapsed()
    );
    drop(client);
}

#[test]
fn who_may_only_watch_changes_nothing() {
    let controller = controller();
    let view = LiveView::watch_only(&controller, 0).expect("a port is free");
    let mut run = Loop::of(controller, view);
    run.say(&json!({
        "op": "setParameters", "id": "set",
        "parameters": [{ "name": "base_position.kp", "value": 12.0 }],
    }));
    run.until("topics", |this| {
        this.channels.contains_key("/view").then_some(())
    });
    for _ in 0..100 {
        run.measurement.time += 0.004;
        run.controller.tick(&run.measurement);
        run.view.update(&mut run.controller, &run.measurement);
        run.listen();
    }
    assert_eq!(run.kp(), Some(9.0));
}

#[test]
fn many_refusals_do_not_cost_the_connection() {
    let mut run = Loop::new();
    let nonsense = (0..5000).map(|i| json!({ "name": format!("nobody.{i}"), "value": 1.0 }));
    let nonsense: Vec<Value> = nonsense.collect();
    run.say(&json!({ "op": "setParameters", "id": "many", "parameters": nonsense }));
    let more = run.until("a summary", |this| {
        let texts = this
            .texts
            .iter()
            .filter_map(|text| text["message"].as_str());
        texts
            .into_iter()
            .find(|text| text.starts_with("and "))
            .map(str::to_owned)
    });
    assert_eq!(more, "and 4996 more");
    assert_eq!(
        run.set("base_position.kp", &json!(10.0))[0]["value"],
        json!(10.0)
    );
}

#[test]
fn the_newest_ticks_win_and_the_others_are_counted() {
    let mut controller = controller();
    let mut view = LiveView::on_port(&controller, 0).expect("a port is free");
    let mut measurement = controller.measurement();
    // Far faster than the view's thread can follow.
    for _ in 0..5000 {
        measurement.time += 0.004;
        controller.tick(&measurement);
        view.update(&mut controller, &measurement);
        view.update(&mut controller, &measurement);
        view.update(&mut controller, &measurement);
    }
    let dropped = view.dropped();
    assert!((1..15_000).contains(&dropped), "{dropped} were dropped");
}

#[test]
fn an_asynchronous_program_has_one_as_well() {
    let runtime = tokio::runtime::Builder::new_current_thread().build();
    runtime.expect("is made").block_on(async {
        let controller = controller();
        let view = LiveView::on_port(&controller, 0).expect("a port is free");
        assert!(view.port() > 0);
    });
}

#[test]
fn a_port_that_is_taken_is_an_error_with_a_remedy() {
    let controller = controller();
    let view = LiveView::on_port(&controller, 0).expect("a port is free");
    let error = LiveView::on_port(&controller, view.port()).expect_err("is taken");
    assert!(matches!(error, LiveError::Server { .. }));
    assert!(error.to_string().contains("give another port"), "{error}");
    // And free again once the view is gone.
    let port = view.port();
    drop(view);
    LiveView::on_port(&controller, port).expect("is free again");
}
