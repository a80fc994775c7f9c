//! Every experiment as published runs on optima alone: nothing of the levels below shows in its results.

use wbqp_measures::experiments;
use wbqp_sim::Scenario;
use wbqp_tests::{files::scenarios, listener::Listener};
use {wbqp_robots as _, wbqp_tasks as _}; // plug-ins are registered by linking

#[test]
fn every_experiment_runs_on_optima_alone() {
    let directory = scenarios();
    let mut count = 0;
    for experiment in experiments::ALL {
        let file = directory.join(format!("{}.toml", experiment.name));
        let scenario = Scenario::from_file(&file).expect("ships");
        for case in scenario.cases() {
            let mut nowhere = Listener::new(|_, _, _| Ok(()));
            let summary = wbqp_sim::run(&scenario, case, 1, &mut nowhere, &mut |_| ());
            let summary = summary.expect("runs");
            println!("{}/{case}: {} ticks", experiment.name, summary.ticks);
            assert_eq!(summary.held, 0, "{}/{case}", experiment.name);
            count += summary.ticks;
        }
    }
    println!("{count} ticks, all optimal");
}
