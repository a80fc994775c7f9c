//! The book's pages: their code is compiled and run with the documentation tests.
#![cfg(doctest)]

#[doc = include_str!("../../docs/in-code.md")]
struct InCode;

#[doc = include_str!("../../docs/configuration.md")]
struct Configuration;

#[doc = include_str!("../../docs/replay.md")]
struct Replay;

#[doc = include_str!("../../docs/how-to/add-a-robot.md")]
struct AddARobot;

#[doc = include_str!("../../docs/how-to/contacts.md")]
struct Contacts;

#[doc = include_str!("../../docs/how-to/connect-hardware.md")]
struct ConnectHardware;

#[doc = include_str!("../../docs/how-to/log-and-plot.md")]
struct LogAndPlot;

#[doc = include_str!("../../README.md")]
struct Readme;
