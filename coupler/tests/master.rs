//! The master alone, with components that note the calls made on them. The physics of the scheme
//! is tested where the rigid bodies are.

use nalgebra::{DMatrix, Point2};
use seakeep_coupler::interface::{
    BoundaryKinematics, Capabilities, Component, ComponentError, ComponentState, Description, Load,
    LoadComponent, LoadResponse, MotionComponent, ValueReference,
};
use seakeep_coupler::{CouplerError, Coupling, Extrapolation, FixedStepMaster, Implicit, Scheme};
use std::cell::RefCell;
use std::rc::Rc;

type Calls = Rc<RefCell<Vec<String>>>;

/// Plays both roles and notes its calls.
struct Double {
    description: Description,
    boundaries: usize,
    kinematics: Vec<BoundaryKinematics>,
    accelerations: Vec<f64>,
    response: LoadResponse,
    loads: Vec<Load>,
    steps: u64,
    /// Number of the step that fails.
    fails_in: u64,
    calls: Calls,
}

const COUPLED: Capabilities = Capabilities {
    can_get_and_set_state: true,
    provides_directional_derivative: true,
    can_handle_variable_step: false,
    has_direct_feedthrough: true,
};
const FREE: Capabilities = Capabilities { has_direct_feedthrough: false, ..COUPLED };

fn double(name: &str, boundaries: usize, capabilities: Capabilities, calls: &Calls) -> Double {
    Double {
        description: Description { name: name.to_owned(), capabilities, variables: Vec::new() },
        boundaries,
        kinematics: vec![BoundaryKinematics::at_rest(Point2::origin(), 0.0); boundaries],
        accelerations: vec![0.0; 3 * boundaries],
        response: LoadResponse::zero(boundaries),
        loads: vec![Load::zero(); boundaries],
        steps: 0,
        fails_in: 0,
        calls: Rc::clone(calls),
    }
}

fn fluid(boundaries: usize) -> Double {
    double("fluid", boundaries, COUPLED, &Calls::default())
}

fn body(bodies: usize) -> Double {
    double("body", bodies, FREE, &Calls::default())
}

impl Double {
    fn note(&self, call: &str) {
        self.calls.borrow_mut().push(format!("{}.{call}", self.description.name));
    }
}

impl Component for Double {
    fn description(&self) -> &Description {
        &self.description
    }
    fn enter_initialization_mode(&mut self, _start_time: f64) -> Result<(), ComponentError> {
        self.note("enter_initialization_mode");
        Ok(())
    }
    fn exit_initialization_mode(&mut self) -> Result<(), ComponentError> {
        self.note("exit_initialization_mode");
        Ok(())
    }
    fn do_step(&mut self, now: f64, _step: f64) -> Result<(), ComponentError> {
        self.note("do_step");
        self.steps += 1;
        if self.steps == self.fails_in {
            let component = self.description.name.clone();
            return Err(ComponentError::CommunicationPoint { component, asked: now, actual: 0.0 });
        }
        Ok(())
    }
    fn terminate(&mut self) {
        self.note("terminate");
    }
    fn get_float64(&self, reference: ValueReference) -> Result<f64, ComponentError> {
        let component = self.description.name.clone();
        Err(ComponentError::UnknownVariable { component, reference })
    }
    fn set_float64(&mut self, reference: ValueReference, _: f64) -> Result<(), ComponentError> {
        self.get_float64(reference).map(|_| ())
    }
    fn get_state(&self) -> Result<ComponentState, ComponentError> {
        ComponentState::save(&self.description.name, &self.steps)
    }
    fn set_state(&mut self, state: &ComponentState) -> Result<(), ComponentError> {
        self.steps = state.load(&self.description.name)?;
        Ok(())
    }
}

impl LoadComponent for Double {
    fn boundary_count(&self) -> usize {
        self.boundaries
    }
    fn set_kinematics(&mut self, kinematics: &[BoundaryKinematics]) {
        assert_eq!(kinematics.len(), self.boundaries);
        self.note("set_kinematics");
    }
    fn solve_load(&mut self, _now: f64, _step: f64) -> Result<&LoadResponse, ComponentError> {
        self.note("solve_load");
        Ok(&self.response)
    }
    fn set_accelerations(&mut self, accelerations: &[f64]) {
        assert_eq!(accelerations.len(), 3 * self.boundaries);
        self.note("set_accelerations");
    }
    fn loads(&self) -> &[Load] {
        &self.loads
    }
}

impl MotionComponent for Double {
    fn body_count(&self) -> usize {
        self.boundaries
    }
    fn kinematics(&self) -> &[BoundaryKinematics] {
        &self.kinematics
    }
    fn set_load(&mut self, _response: &LoadResponse) {
        self.note("set_load");
    }
    fn mean_accelerations(&self) -> &[f64] {
        &self.accelerations
    }
}

#[test]
fn calls_come_in_the_order_of_the_scheme() {
    let calls = Calls::default();
    let mut fluid = double("fluid", 1, COUPLED, &calls);
    let mut body = double("body", 1, FREE, &calls);
    let mut master =
        FixedStepMaster::start(0.0, 0.1, &mut fluid, Some(&mut body)).expect("they fit");
    let start = [
        "fluid.enter_initialization_mode",
        "body.enter_initialization_mode",
        "body.exit_initialization_mode",
        "fluid.set_kinematics",
        "fluid.exit_initialization_mode",
    ];
    assert_eq!(calls.take(), start);
    master.step(&mut fluid, Some(&mut body)).expect("a good step");
    let step = [
        "fluid.set_kinematics",
        "fluid.solve_load",
        "body.set_load",
        "body.do_step",
        "fluid.set_accelerations",
        "fluid.do_step",
    ];
    assert_eq!(calls.take(), step);
    master.finish(&mut fluid, Some(&mut body));
    assert_eq!(calls.take(), ["fluid.terminate", "body.terminate"]);
}

#[test]
fn a_fluid_without_boundaries_runs_alone() {
    let mut fluid = fluid(0);
    let mut master = FixedStepMaster::start(0.0, 0.1, &mut fluid, None).expect("it fits");
    for step in 1..=10 {
        let report = master.step(&mut fluid, None).expect("a good step");
        assert_eq!((report.step, report.power_bond_residual), (step, 0.0));
    }
    assert_eq!(fluid.steps, 10);
    let saved = master.save(&fluid, None).expect("it can");
    master.step(&mut fluid, None).expect("a good step");
    master.restore(&mut fluid, None, &saved).expect("its own");
    assert_eq!((fluid.steps, master.step_count()), (10, 10));
    master.finish(&mut fluid, None);
}

/// A sum of 100,000 steps of 0.1 ms would be off by 2e-11 s; the count is not off at all.
#[test]
fn time_does_not_drift() {
    let mut fluid = fluid(0);
    let mut master = FixedStepMaster::start(2.0, 1e-4, &mut fluid, None).expect("it fits");
    for _ in 0..100_000 {
        let report = master.step(&mut fluid, None).expect("a good step");
        assert_eq!(report.time, master.time());
        fluid.calls.borrow_mut().clear();
    }
    assert_eq!(master.time(), 12.0);
}

#[test]
fn combinations_that_cannot_work_are_refused() {
    let refusal = |mut fluid: Double, mut body: Option<Double>| {
        let motion = body.as_mut().map(|body| body as &mut dyn MotionComponent);
        let error = FixedStepMaster::start(0.0, 0.1, &mut fluid, motion).expect_err("a refusal");
        assert!(fluid.calls.borrow().is_empty(), "nothing is initialized");
        error
    };
    let error = refusal(fluid(2), Some(body(1)));
    assert_eq!(error.to_string(), "fluid has 2 boundaries, but body moves 1");
    let error = refusal(fluid(1), None);
    assert!(matches!(error, CouplerError::BoundaryCount { motion_bodies: 0, .. }), "{error}");

    let calls = Calls::default();
    let lagging = Capabilities { provides_directional_derivative: false, ..COUPLED };
    let error = refusal(double("fluid", 1, lagging, &calls), Some(body(1)));
    assert!(matches!(error, CouplerError::FeedthroughWithoutDerivative { .. }), "{error}");
    let error = refusal(fluid(1), Some(double("body", 1, COUPLED, &calls)));
    assert!(matches!(error, CouplerError::MotionFeedthrough { .. }), "{error}");

    for (start, step) in [(0.0, 0.0), (0.0, -1.0), (0.0, f64::NAN), (f64::INFINITY, 0.1)] {
        let error =
            FixedStepMaster::start(start, step, &mut fluid(0), None).expect_err("a refusal");
        assert!(matches!(error, CouplerError::Time { .. }), "{error}");
    }
    // Without feedthrough there is no loop to close; without boundaries neither.
    let free = Capabilities { provides_directional_derivative: false, ..FREE };
    let mut fluid = double("fluid", 1, free, &calls);
    FixedStepMaster::start(0.0, 0.1, &mut fluid, Some(&mut body(1))).expect("it can work");
    let mut fluid = double("fluid", 0, lagging, &calls);
    FixedStepMaster::start(0.0, 0.1, &mut fluid, None).expect("it can work");
}

/// What a scheme needs of the components, and what its parameters may be.
#[test]
fn a_scheme_refuses_what_it_cannot_do() {
    let calls = Calls::default();
    let implicit =
        |settings| Coupling { scheme: Scheme::Implicit(settings), ..Coupling::default() };
    let start = |coupling, load: Capabilities, motion: Capabilities| {
        let mut fluid = double("fluid", 1, load, &calls);
        let mut body = double("body", 1, motion, &calls);
        let started = FixedStepMaster::start_with(coupling, 0.0, 0.1, &mut fluid, Some(&mut body));
        started.map(|_| ()).map_err(|error| error.to_string())
    };
    let stateless = |with: Capabilities| Capabilities { can_get_and_set_state: false, ..with };
    let blind = |with| Capabilities { provides_directional_derivative: false, ..with };
    let repeat = |name: &str| {
        format!("an implicit scheme repeats steps, but {name} cannot save and restore its state")
    };
    let iterate = implicit(Implicit::default());
    assert_eq!(start(iterate, COUPLED, stateless(FREE)), Err(repeat("body")));
    assert_eq!(start(iterate, stateless(blind(COUPLED)), FREE), Err(repeat("fluid")));
    let subcycled = Coupling { load_substeps: 2, ..iterate };
    assert_eq!(start(subcycled, stateless(COUPLED), FREE), Err(repeat("fluid")));
    // With the derivative, and one step in a communication step, the load is never repeated.
    assert_eq!(start(iterate, stateless(COUPLED), FREE), Ok(()));
    assert_eq!(
        start(Coupling::default(), blind(COUPLED), FREE),
        Err("the load of fluid depends at once on the acceleration, but it does not provide the \
             directional derivative that this scheme needs to stay stable; iterate instead"
            .to_owned())
    );
    for scheme in [Scheme::Jacobi, Scheme::GaussSeidel, iterate.scheme] {
        let coupling = Coupling { scheme, ..Coupling::default() };
        assert_eq!(start(coupling, blind(COUPLED), FREE), Ok(()));
    }
    let refused =
        |coupling, words: &str| assert_eq!(start(coupling, COUPLED, FREE), Err(words.to_owned()));
    let rates = |load_substeps, motion_substeps| Coupling {
        load_substeps,
        motion_substeps,
        extrapolation: Extrapolation::Linear,
        ..Coupling::default()
    };
    refused(rates(0, 1), "load substeps = 0 of the coupling must be at least 1");
    refused(rates(1, 0), "motion substeps = 0 of the coupling must be at least 1");
    let default = Implicit::default();
    for relaxation in [0.0, 1.1, f64::NAN] {
        refused(
            implicit(Implicit { relaxation, ..default }),
            &format!("relaxation = {relaxation} of the coupling must be in (0, 1]"),
        );
    }
    refused(
        implicit(Implicit { tolerance: 0.0, ..default }),
        "tolerance = 0 of the coupling must be in (0, 1)",
    );
    refused(
        implicit(Implicit { max_iterations: 0, ..default }),
        "iterations = 0 of the coupling must be at least 1",
    );
}

#[test]
fn a_failure_carries_time_and_step() {
    let (mut fluid, mut body) = (fluid(1), body(1));
    body.fails_in = 3;
    let mut master =
        FixedStepMaster::start(1.0, 0.5, &mut fluid, Some(&mut body)).expect("they fit");
    for _ in 0..2 {
        master.step(&mut fluid, Some(&mut body)).expect("a good step");
    }
    let error = master.step(&mut fluid, Some(&mut body)).expect_err("the third step fails");
    assert!(matches!(error, CouplerError::Component { time: 2.0, step: 3, .. }), "{error:?}");
    assert_eq!(master.step_count(), 2);
}

#[test]
fn wrong_numbers_of_values_are_errors() {
    type Damage = fn(&mut Double, &mut Double);
    let cases: [(&str, Damage); 5] = [
        ("kinematics", |_, body| body.kinematics.clear()),
        ("accelerations", |_, body| body.accelerations.clear()),
        ("loads", |fluid, _| fluid.response = LoadResponse::zero(2)),
        ("columns of added mass", |fluid, _| fluid.response.added_mass = DMatrix::zeros(3, 4)),
        ("loads", |fluid, _| fluid.loads.clear()),
    ];
    for (quantity, damage) in cases {
        let (mut fluid, mut body) = (fluid(1), body(1));
        let mut master =
            FixedStepMaster::start(0.0, 0.1, &mut fluid, Some(&mut body)).expect("they fit");
        damage(&mut fluid, &mut body);
        let error = master.step(&mut fluid, Some(&mut body)).expect_err("a wrong number");
        match error {
            CouplerError::Length { quantity: named, step: 1, .. } => assert_eq!(named, quantity),
            other => panic!("{other}"),
        }
    }
}

#[test]
fn a_component_without_state_cannot_be_saved() {
    let stateless = Capabilities { can_get_and_set_state: false, ..COUPLED };
    let mut fluid = double("fluid", 1, stateless, &Calls::default());
    let mut body = body(1);
    let master = FixedStepMaster::start(0.0, 0.1, &mut fluid, Some(&mut body)).expect("they fit");
    let error = master.save(&fluid, Some(&body)).expect_err("it cannot");
    assert_eq!(error.to_string(), "fluid cannot save and restore its state");
}
