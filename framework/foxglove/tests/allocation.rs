//! Neither a tick nor its showing allocates, with a client that is connected and does not listen.

use std::{net::TcpStream, path::Path, thread, time::Duration};

use assert_no_alloc::{AllocDisabler, assert_no_alloc, violation_count};
use tungstenite::{ClientRequestBuilder, Message, WebSocket, http::Uri, stream::MaybeTlsStream};
use wbqp::{Controller, ControllerConfig};
use wbqp_foxglove::LiveView;

use {wbqp_robots as _, wbqp_tasks as _};

// Counts the allocations of the thread that asks: those of the view's threads are their own.
#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const CONFIG: &str = r#"
[controller]
rate = 1000.0
hover = "unchecked"

[robot]
type = "quadruped"

[[task]]
name = "posture"
type = "posture"
weight = 1.0
kp = 20.0
kd = 5.0
"#;

/// A client that subscribes to everything and reads nothing.
fn deaf_client(port: u16) -> WebSocket<MaybeTlsStream<TcpStream>> {
    let address: Uri = format!("ws://127.0.0.1:{port}")
        .parse()
        .expect("is an address");
    let request = ClientRequestBuilder::new(address).with_sub_protocol("foxglove.sdk.v1");
    let (mut client, _) = tungstenite::connect(request).expect("connects");
    let all = (1..40).map(|id| format!(r#"{{"id":{id},"channelId":{id}}}"#));
    let all = all.collect::<Vec<_>>().join(",");
    let text = format!(r#"{{"op":"subscribe","subscriptions":[{all}]}}"#);
    client.send(Message::text(text)).expect("is sent");
    client
}

#[test]
fn a_tick_that_is_shown_does_not_allocate() {
    let config = ControllerConfig::from_str(CONFIG, "live.toml", Path::new(".")).expect("is read");
    let mut controller = Controller::new(config).expect("is made");
    let mut view = LiveView::on_port(&controller, 0).expect("a port is free");
    let _client = deaf_client(view.port());
    let mut measurement = controller.measurement();
    // The counter counts at all.
    assert_no_alloc(|| drop(std::hint::black_box(Box::new(1))));
    let counted = violation_count();
    assert!(counted > 0, "allocations are not seen");
    for _ in 0..2000 {
        measurement.time += 0.001;
        assert_no_alloc(|| {
            controller.tick(&measurement);
            view.update(&mut controller, &measurement);
        });
        thread::sleep(Duration::from_micros(100));
    }
    assert_eq!(violation_count(), counted, "the loop has allocated");
}
