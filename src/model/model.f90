!> Types of the model: bodies, points, joints, drivers, loads, requests. The model is constant once it is built. It contains neither
!> text of the deck nor states. Floor: model.
module limber_model_model
   use limber_base_kinds, only: wp, long
   use limber_base_names, only: name_index_type
   use limber_deck_expression, only: expression_type
   use limber_beam_exact_profile, only: profile_type
   use limber_beam_plane_frame, only: frame_type
   use limber_beam_frame_reduction, only: frame_choice_type
   use limber_beam_beam_mesh, only: beam_type, displacement_field_type
   use limber_model_curve, only: curve_type
   use limber_model_law_integrals, only: integral_type
   use limber_beam_force_recovery, only: recovery_type
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_beam_reduction, only: reduction_type
   implicit none
   private
   public :: model_type, body_type, whole_type, point_type, joint_type, function_term_type, term_type, driver_type
   public :: deflection_type
   public :: load_part_type, distributed_load_type, named_load_type, scalar_type, event_type, switch_type, control_type
   public :: limit_contact_type
   public :: dynamics_type, analysis_step_type, channel_type, quantity_type, dimension_type, units_type

   !> Kinds of bodies: a point mass has a position only, other bodies also have a direction
   integer, parameter, public :: body_point = 1, body_rigid = 2, body_flexible = 3
   !> What a joint demands of the place of its first point: nothing; the place of the second; a line through that, at ANGLE; a curve
   !> around it; the line of a beam; a distance from it. Or wheels roll on each other, whose centres others hold
   integer, parameter, public :: place_free = 0, place_at_point = 1, place_on_line = 2, place_on_curve = 3, place_on_beam = 4, &
      & place_at_distance = 5, place_rolling = 6
   !> Scalar functions of the equations of joints: coordinate of the first point from the second along an axis of space; the same
   !> along a
   !> line in the section of the second; sine of the angle of the sections less TURN, times the characteristic length; distance of
   !> the points;
   !> angle of one section; direction from the first point to the second. Angles count turns
   integer, parameter, public :: function_component = 1, function_displacement = 2, function_parallel = 3, function_distance = 4, &
      & function_section_angle = 5, function_direction = 6
   !> Joint coordinates for couplers and drivers: angle of a body's frame; angle of a joint's first section relative to the second;
   !> position of a joint's first point along its line
   integer, parameter, public :: coordinate_angle = 1, coordinate_joint_angle = 2, coordinate_displacement = 3
   !> Coordinate of a driver: angle of a body or joint, distance of two points, position along the line of a joint, x or y of a
   !> point
   integer, parameter, public :: driver_angle = 1, driver_joint_angle = 2, driver_distance = 3, driver_displacement = 4, &
      & driver_x = 5, driver_y = 6
   !> Kinds of analyses
   integer, parameter, public :: step_kinematics = 1, step_inverse = 2, step_statics = 3, step_modes = 4, step_dynamics = 5
   !> Action of a static analysis at an unstable equilibrium
   integer, parameter, public :: leave_unstable = 1, stay_unstable = 2, stop_unstable = 3
   !> Initial velocities of a dynamic analysis: from the end of the analysis before, zero, from the deck
   integer, parameter, public :: velocities_kept = 1, velocities_none = 2, velocities_of_deck = 3
   !> Actions of an event: it is noted; it ends the run, or the analysis; it turns a switch
   integer, parameter, public :: event_sample = 1, event_stop = 2, event_end_step = 3, event_switch = 4
   !> What an event does to a switch
   integer, parameter, public :: turn_on = 1, turn_off = 2, toggle = 3
   !> Index of the ground, in place of a body
   integer, parameter, public :: ground = 0

   !> Coordinate of a load: displacement of P1 along a fixed axis, relative to P2 if there is one; displacement of P1 along an axis
   !> of its section; distance of P1 and P2; position of P1 from P2 along an axis of the section at P2; angle of the section at P1
   !> less that at P2
   integer, parameter, public :: along_axis = 1, along_follower = 2, along_distance = 3, along_slide = 4, along_angle = 5
   !> Largest number of coordinates of a beam in a sliding joint
   integer, parameter, public :: most_bends = 24
   !> Largest number of variables in the law of a load
   integer, parameter, public :: most_slots = 15
   !> Kinds of summaries of a channel, and their names
   integer, parameter, public :: summary_first = 1, summary_last = 2, summary_minimum = 3, summary_maximum = 4, &
      & summary_mean = 5, summary_rms = 6
   character(7), parameter, public :: summary_names(6) = [character(7) :: 'first', 'last', 'minimum', 'maximum', 'mean', 'rms']
   !> In place of a quantity of the table: elongation and rate of the spring itself, in its law
   integer, parameter, public :: own_elongation = -1, own_rate = -2

   !> Dimension of a number
   type :: dimension_type
      !> Exponents of length, time and mass, and of angles
      integer :: exponents(3) = 0, turns = 0
      !> True for an unknown dimension; true for a moment in distinction from an energy
      logical :: open = .false., moment = .false.
   end type dimension_type

   !> A quantity in an expression
   type :: quantity_type
      !> Index into the table of quantities; 0: the time; or own_elongation, own_rate
      integer :: kind = 0
      !> Index of its object: a point, body, joint, driver or named load
      integer :: of = 0
      !> True if the object is a named load
      logical :: of_load = .false.
      !> True if the object is a coupler, an entry of the joints
      logical :: of_coupler = .false.
      !> Dimension: exponents of length, time and mass; true for an angle or its rate
      integer :: dimension(3) = 0
      logical :: angular = .false.
   end type quantity_type

   !> A body, with its initial guess of position and velocity
   type :: body_type
      !> Name as the deck writes it
      character(:), allocatable :: name
      !> body_point, body_rigid or body_flexible
      integer :: kind = body_rigid
      !> Mass, stiffness and inertia terms for the time loop
      type(reduced_type) :: reduced
      !> Guess of the frame's origin (2) [length], angle [rad], and their rates
      real(wp) :: position(2) = 0.0_wp, angle = 0.0_wp, velocity(2) = 0.0_wp, spin = 0.0_wp
      !> Whether the deck gives X, Y, ANGLE, VX, VY, SPIN (6)
      logical :: given(6) = .false.
      !> Largest distance between two points or nodes [length]
      real(wp) :: size = 0.0_wp
      !> Largest displacement in the shapes of the coordinates [1/sqrt(mass)]
      real(wp) :: largest_shape = 0.0_wp
      !> Beam of a flexible body: its data, its reduction options, and its mode shapes at the nodes
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(displacement_field_type) :: field
      !> Text on dependent functions that were left out of the basis; empty if there were none
      character(:), allocatable :: note
      !> Of a frame: largest part of the strain energy of a response that is lost, as its modes leave no mass for it
      real(wp) :: lost = 0.0_wp
      !> Damping ratios of the body's modes under its supports (n), allocated if a ratio or the mass factor is not zero; Rayleigh
      !> factors of mass [1/time] and of stiffness [time]
      real(wp), allocatable :: ratio(:)
      real(wp) :: rayleigh(2) = 0.0_wp
      !> Indices of the points at both ends of a beam
      integer :: start_point = 0, end_point = 0
      !> True for a frame; its mesh, its reduction options, and its shapes at the nodes (3, nodes, n)
      logical :: is_frame = .false.
      type(frame_type) :: mesh
      !> Numbers of the members in the deck (members)
      integer, allocatable :: member_numbers(:)
      type(frame_choice_type) :: frame_choice
      real(wp), allocatable :: shape(:, :, :)
      !> Cross-section of each member, for a beam of its only one: area [length^2], second moment of area [length^4], distances of
      !> the extreme fibres to the left and right of the axis [length], 0 if unknown (4, members)
      real(wp), allocatable :: strength(:, :)
      !> The same along an exact beam, with the second moment of area of the curved beam; else its values are not allocated
      type(profile_type) :: fibres
      !> Coefficients of section forces: at points first, then, for an envelope, along the whole body
      type(recovery_type) :: recovery
      logical :: envelope = .false.
      !> Number of sections at points
      integer :: point_sections = 0
      !> Relative error for want of shear of the first frequency, or of the static deflection; for a whole in its first body. Number
      !> of the frame's member with the largest contribution
      real(wp) :: unsheared = 0.0_wp
      integer :: shortest = 0
      !> Index of the first flexible beam with the same reduction, possibly this beam
      integer :: twin = 0
      !> Index of the whole of a piece; 0 for other bodies
      integer :: whole = 0
      !> Index of the control of which it carries a state: a point of unit mass and without weight or energy, whose velocity along x
      !> is the state; 0 for bodies of the deck. Size of the state below which errors do not shrink
      integer :: control = 0
      real(wp) :: state_scale = 0.0_wp
   end type body_type

   !> A beam of the deck in pieces, which are bodies welded together. Its name refers to the first piece. If the start is clamped,
   !> the frame of the first piece is that of the whole beam. Or a frame of exact beams, with its axes on the section at the start
   !> of the first member.
   type :: whole_type
      character(:), allocatable :: name
      !> First and last piece
      integer :: first = 0, last = 0
      !> Undeformed length; coordinate of the frame's origin along the beam [length]
      real(wp) :: length = 0.0_wp, origin = 0.0_wp
      !> True if the frame is the section at the start, false if it lies along the chord
      logical :: clamped = .false.
      !> Number of welds between the pieces
      integer :: inner = 0
      !> Frame of exact beams: numbers of the members in the deck, position of the start (2, members) [length] and direction [rad]
      !> of each member in the axes of the frame
      integer, allocatable :: member_numbers(:)
      real(wp), allocatable :: place(:, :), lean(:)
   end type whole_type

   !> A named point of a body, or of the ground
   type :: point_type
      !> Name of the body and of the point: 'rod.middle'
      character(:), allocatable :: name
      !> Index of the body, or `ground`
      integer :: body = ground
      !> Undeformed position in the body frame (2), of a ground point in space [length]
      real(wp) :: p0(2) = 0.0_wp
      !> Displacement (2,n) and rotation of the section (n) for unit coordinates of the body
      real(wp), allocatable :: phi(:, :), psi(:)
      !> True for a point or direction of an exact beam: its section turns by psi.eta. Weights of the beam's stations in the
      !> position of the point (stations) [length]
      logical :: exact = .false.
      real(wp), allocatable :: reach(:)
      !> True for a direction of the section: p0 is a unit vector, phi its change by psi, and the origin of the frame has no effect.
      !> The system makes directions from points
      logical :: direction = .false.
      !> Point of a beam or frame: its member, number of members at the point, coordinate along this member [length]
      integer :: member = 0, meeting = 1
      real(wp) :: along = 0.0_wp
      !> Point of a frame of exact beams: angle of its member in the frame [rad]; the axes of the point are parallel to the frame's
      real(wp) :: lean = 0.0_wp
      !> Index of its section among those of the body with section forces; 0 if none
      integer :: section = 0
   end type point_type

   !> A distributed load that is represented by a force at a point; for the section forces under this load
   type :: distributed_load_type
      !> Index of the point, index of its member
      integer :: point = 0, member = 1
      !> Start and end of the load along the body [length]
      real(wp) :: ends(2) = 0.0_wp
      !> Load as a function of the coordinate s along the beam or member; s at the start of the body [length]; constant added to the
      !> load [force/length]; resultant [force]
      type(expression_type) :: law
      real(wp) :: start = 0.0_wp, added = 0.0_wp, total = 1.0_wp
      !> Number of the Gauss point whose share of the load this is, by its Lagrange polynomial; 0 for the whole load
      integer :: station = 0
   end type distributed_load_type

   !> A term of a coupler
   type :: term_type
      real(wp) :: coefficient = 0.0_wp
      !> Kind of joint coordinate, and index of the body or joint
      integer :: kind = 0, of = 0
   end type term_type

   !> A term of an equation of a joint: a coefficient times a scalar function
   type :: function_term_type
      !> Number of the equation; the function: function_component, ...
      integer :: row = 1, function = 0
      !> Direction of the axis or line [rad]; point of a section angle
      real(wp) :: angle = 0.0_wp
      integer :: side = 0
      real(wp) :: coefficient = 1.0_wp
      !> Whether the coefficient changes its sign if the first point is on the right of the joint's line in the first guess
      logical :: by_side = .false.
   end type function_term_type

   !> A joint between two points
   type :: joint_type
      character(:), allocatable :: name
      !> What it demands of the place of its first point; whether it keeps the angle of the first section from the second
      integer :: place = place_free
      logical :: keeps_angle = .false.
      !> Name of its symbol in drawings
      character(:), allocatable :: symbol
      !> Terms of its equations. Each equation keeps the value that it has in the first guess, or is zero if `zero`, or LENGTH if
      !> that is given
      type(function_term_type), allocatable :: functions(:)
      logical :: zero = .true.
      !> Indices of the two points
      integer :: points(2) = 0
      !> Direction of the line in the section of the second body [rad]
      real(wp) :: angle = 0.0_wp
      !> Angle of the first section relative to the second, for weld and translational joints [rad]; length of a rod [length];
      !> values of the initial guess if the deck gives none
      real(wp) :: turn = 0.0_wp, length = 0.0_wp
      logical :: has_turn = .false., has_length = .false.
      !> Radii of gears, wheels, or of a pinion [length]
      real(wp) :: radius(2) = 0.0_wp
      !> True if both turn in the same direction: internal gears, open belt
      logical :: same_direction = .false.
      !> Curve of a point-on-curve joint
      type(curve_type) :: curve
      !> Whether the joint supports the beam on either side across its axis at the start: false for a body that only hangs on the
      !> beam, or slides across it. Whether it prevents rotation without such a support
      logical :: bears(2) = .true., guides(2) = .false.
      !> Terms of a coupler, and their sum as a function of time; without a law, the sum of the initial guess
      type(term_type), allocatable :: terms(:)
      logical :: has_law = .false.
      type(expression_type) :: law
      !> Index of the switch while which is on it has equations; negative: while which is off; 0: always
      integer :: switch = 0
   contains
      procedure :: is_hinge, is_weld, is_coupler
   end type joint_type

   !> A motion prescribed in time
   type :: driver_type
      character(:), allocatable :: name
      !> driver_angle, ...
      integer :: kind = driver_angle
      !> Indices of body, joint and points, as the kind needs them
      integer :: body = 0, joint = 0, points(2) = 0
      !> Prescribed coordinate as a function of t [rad or length], or one of its derivatives
      type(expression_type) :: law
      !> Derivative given by the law: 0 coordinate, 1 velocity, 2 acceleration
      integer :: level = 0
      !> Levels 1 and 2: initial coordinate and velocity
      real(wp) :: initial(2) = 0.0_wp
      !> Whether the deck gives the initial coordinate; else that of the initial guess
      logical :: has_initial = .false.
      !> Integrals of the law, for levels 1 and 2
      type(integral_type) :: integral
      !> As of a joint
      integer :: switch = 0
   end type driver_type

   !> A part of a load: force or torque along a scalar function s of the motion, -k (s - origin) - c s' plus the law times a factor
   type :: load_part_type
      !> Kind of s: along_axis, along_follower, along_distance, along_slide or along_angle
      integer :: along = 0
      !> Indices of one or two points: P1 and P2; the second may be 0
      integer :: points(2) = 0
      !> Angle of the axis [rad], of a follower in the section at P1, of a slide in the section at P2
      real(wp) :: angle = 0.0_wp
      !> Free length or angle, k, c, and the factor of the law
      real(wp) :: origin = 0.0_wp, stiffness = 0.0_wp, damping = 0.0_wp, factor = 1.0_wp
      !> Whether there is a law; the law, and the quantities of its variables (slots)
      logical :: driven = .false.
      type(expression_type) :: law
      type(quantity_type), allocatable :: quantities(:)
      !> As of a joint
      integer :: switch = 0
      !> Index of the control of which it is the rate of a state; 0 for loads of the deck
      integer :: control = 0
   contains
      procedure :: is_of_time, is_constant
   end type load_part_type

   !> A load as the deck names it
   type :: named_load_type
      character(:), allocatable :: name
      !> Index of its first and last part in the list of the model
      integer :: first = 0, last = 0
      !> Bushing: whether the deck gives it a stiffness or damping along its axes and against rotation (3)
      logical :: resists(3) = .true.
      !> Whether it has an elongation; whether this is an angle; whether it holds two sections near each other, so that it has
      !> components
      !> in the axes of the second
      logical :: stretches = .false., angular = .false., holds_sections = .false.
      !> Of an angle: whether it is that of the first body less that of the second, as joint_angle; else the other way
      logical :: from_second = .false.
      !> Name of its symbol in drawings; empty: it is not drawn
      character(:), allocatable :: symbol
   end type named_load_type

   !> A requested channel: an expression of quantities
   type :: channel_type
      character(:), allocatable :: name
      !> Text of its expression, and its units
      character(:), allocatable :: long_name, units
      type(dimension_type) :: dimension
      !> Text on the reference of its displacements and angles; empty if it needs none
      character(:), allocatable :: reference
      type(expression_type) :: expression
      !> Quantity of each variable (slots)
      type(quantity_type), allocatable :: quantities(:)
   end type channel_type

   !> A scalar of a run: an expression of summaries of channels over all samples
   type :: scalar_type
      character(:), allocatable :: name
      !> Text of its expression, and its units
      character(:), allocatable :: long_name, units
      type(expression_type) :: expression
      !> Of each variable: kind of summary, and index of the channel (slots)
      integer, allocatable :: summaries(:), channels(:)
   end type scalar_type

   !> An event: a scalar of the motion that crosses zero
   type :: event_type
      !> Name, and the scalar as the deck writes it
      character(:), allocatable :: name, text
      !> The scalar, and the quantities that it depends on
      type(expression_type) :: law
      type(quantity_type), allocatable :: quantities(:)
      !> Crossings that count: 1 upwards, -1 downwards, 0 both
      integer :: direction = 0
      !> Time before which none counts
      real(wp) :: after = -huge(1.0_wp)
      !> What happens: event_sample, ...; the crossing at which it does, among those that count; of event_switch the first one
      integer :: action = event_sample, number = 1
      !> Index of the switch that it turns, 0: none; turn_on, turn_off or toggle
      integer :: switch = 0, to = turn_on
      !> Index of the control whose limit it is, of the contact that it lets touch; both 0 for events of the deck
      integer :: control = 0, contact = 0
   end type event_type

   !> A switch: loads, joints and drivers act while it is on, or while it is off
   type :: switch_type
      character(:), allocatable :: name
      !> Whether it is on at the start
      logical :: on = .true.
   end type switch_type

   !> A limit of a rigid stop: the gap  side (s - limit)  cannot be negative, s as of its load without its free length
   type :: limit_contact_type
      !> Name in the table of events: that of the stop, with two limits also which of them
      character(:), allocatable :: name
      !> Index of the named load that has s, of the switch that is on while the contact is closed, of the event of the touch
      integer :: load = 0, switch = 0, event = 0
      !> 1: s is at least the limit, -1: at most
      integer :: side = 1
      !> Limit [length or rad]; restitution, the speed behind an impact over that before
      real(wp) :: limit = 0.0_wp, restitution = 0.0_wp
      !> Index of its block in the deck, for messages
      integer :: block = 0
   end type limit_contact_type

   !> A control: its output is a function of its states and inputs, which any law may depend on
   type :: control_type
      character(:), allocatable :: name
      !> Inputs u1, u2, ... as functions of the motion
      type(expression_type), allocatable :: inputs(:)
      !> Output, and rates of the states that have one, as functions of inputs and states s1, s2, ... The output then of what these
      !> depend on
      type(expression_type) :: output
      type(expression_type), allocatable :: rates(:)
      !> Points of the bodies that carry the states (states)
      integer, allocatable :: points(:)
      !> First value of each state, and what is added to it for each unit of the first input at the start (states)
      real(wp), allocatable :: first(:), first_gain(:)
      !> The first input as a law, and the quantities that it depends on
      type(expression_type) :: law
      type(quantity_type), allocatable :: quantities(:)
      !> Of a sampled one: period, and time from a sample to the output that follows from it; 0: it is not sampled
      real(wp) :: period = 0.0_wp, delay = 0.0_wp
      !> Whether its samples may come from outside
      logical :: is_input = .false.
      !> Its gains of the input, of the sum and of the difference; limits of its output
      real(wp) :: gains(3) = 0.0_wp, least = -huge(1.0_wp), most = huge(1.0_wp)
      !> Of a hysteresis: index of the switch that its output follows, 0: none; its input less the limit above, and less that below
      integer :: switch = 0
      type(expression_type) :: above, below
      !> Index of its block in the deck, for messages
      integer :: block = 0
   end type control_type

   !> Options of an analysis in time, mainly of a dynamic one
   type :: dynamics_type
      !> True if the deck asks for an analysis
      logical :: wanted = .false.
      !> First and last time
      real(wp) :: start = 0.0_wp, end = 0.0_wp
      !> Number of equal intervals between samples
      integer :: outputs = 100
      !> Local error allowed in a step, relative to each scale
      real(wp) :: tolerance = 1.0e-6_wp
      !> Name of the integrator; reason of its choice if limber chooses it
      character(:), allocatable :: integrator, reason
      !> Spectral radius at infinity of ALPHA
      real(wp) :: spectral_radius = 0.8_wp
      !> First and largest step; 0: chosen automatically, no limit
      real(wp) :: initial_step = 0.0_wp, maximum_step = 0.0_wp
      !> Length of every step; 0: chosen by error control
      real(wp) :: fixed_step = 0.0_wp
      !> Largest number of steps
      integer :: maximum_steps = 100000000
   contains
      procedure :: finer
   end type dynamics_type

   !> Initial value of a beam's coordinate
   type :: deflection_type
      !> Index of the body, index of the coordinate
      integer :: body = 0, coordinate = 0
      !> Its value [length sqrt(mass)] and rate
      real(wp) :: value = 0.0_wp, rate = 0.0_wp
   end type deflection_type

   !> Options of the assembly
   type :: assembly_choice_type
      !> Largest rotation between guess and first position without a warning [rad]
      real(wp) :: largest_turn = 0.5_wp
      !> Whether initial deflections are in equilibrium with loads and inertia
      logical :: static_deflections = .false.
      !> Whether their initial rates follow this equilibrium along the motion
      logical :: following = .false.
      !> Whether articulated trees and known bodies are solved without unknowns and multipliers
      logical :: elimination = .true.
      !> Given initial deflections; all others are zero
      type(deflection_type), allocatable :: deflections(:)
   end type assembly_choice_type
   !> An analysis: a step of the deck, which starts from the end of the one before
   type :: analysis_step_type
      !> One of the kinds of analyses
      integer :: kind = step_dynamics
      !> Name in the results, and index of the deck's block
      character(:), allocatable :: name
      integer :: block = 0
      !> First and last time, samples; all options of a dynamic analysis
      type(dynamics_type) :: dynamics
      !> Whether it begins when the one before ends
      logical :: follows = .true.
      !> Dynamics: initial velocities
      integer :: velocities = velocities_kept
      !> Kinematics and inverse dynamics: whether deflections are in equilibrium at each sample, or fixed
      logical :: static_deflections = .false.
      !> Statics: whether constant loads grow from zero, and the action at an unstable equilibrium
      logical :: ramp = .false.
      integer :: instability = leave_unstable
      !> Statics: angular velocity of a steady rotation of the whole scene at the end [rad/time], and its centre (2) [length]
      real(wp) :: rotation = 0.0_wp, centre(2) = 0.0_wp
      !> Modes: their number, and whether with damping
      integer :: modes = 10
      logical :: damped = .false.
   end type analysis_step_type

   !> Options of the error estimate and of the search for an accuracy
   type :: accuracy_type
      !> True for an error estimate of each channel
      logical :: estimate = .false.
      !> Target error relative to the largest value of each channel; 0: none
      real(wp) :: target = 0.0_wp
   end type accuracy_type

   !> Names of the units of the deck's numbers; only labels of results
   type :: units_type
      character(:), allocatable :: length, time, mass
   end type units_type

   !> Numbers of items in the lists of a model; while it is built, the lists may be longer
   type :: counts_type
      integer :: bodies = 0, points = 0, joints = 0, channels = 0
   end type counts_type

   !> The whole model
   type :: model_type
      !> Memory of the constants of all bodies [bytes]
      integer(long) :: bytes = 0
      !> Text of *HEADING
      character(:), allocatable :: heading
      type(units_type) :: units
      !> Acceleration of gravity (2) [length/time^2]
      real(wp) :: gravity(2) = 0.0_wp
      type(body_type), allocatable :: bodies(:)
      !> Beams in segments; their pieces are bodies
      type(whole_type), allocatable :: wholes(:)
      type(point_type), allocatable :: points(:)
      type(joint_type), allocatable :: joints(:)
      type(driver_type), allocatable :: drivers(:)
      !> All named loads, and their parts in the same order
      type(named_load_type), allocatable :: loads(:)
      type(load_part_type), allocatable :: load_parts(:)
      !> Distributed loads, used while the model is built
      type(distributed_load_type), allocatable :: spreads(:)
      type(channel_type), allocatable :: channels(:)
      type(scalar_type), allocatable :: scalars(:)
      type(event_type), allocatable :: events(:)
      type(switch_type), allocatable :: switches(:)
      type(control_type), allocatable :: controls(:)
      type(limit_contact_type), allocatable :: contacts(:)
      !> True for motion records: samples of the coordinates of all bodies, for drawings
      logical :: motion = .false.
      type(assembly_choice_type) :: assembly
      !> Analyses in order, not allocated if there are none; options of the active analysis
      type(analysis_step_type), allocatable :: steps(:)
      type(dynamics_type) :: dynamics
      type(accuracy_type) :: accuracy
      !> Characteristic length: the largest size of a body, else the extent of the initial positions [length]
      real(wp) :: length = 0.0_wp
      !> While the model is built: numbers of items, and indices by name: 'body rod', 'point rod.end', ...
      type(counts_type) :: counts
      type(name_index_type) :: names
   end type model_type

contains

   !> Whether a joint leaves a rotation about a point and nothing else.
   pure logical function is_hinge(self)
      class(joint_type), intent(in) :: self
      is_hinge = self%place == place_at_point .and. .not. self%keeps_angle
   end function is_hinge

   !> Whether a joint leaves no motion.
   pure logical function is_weld(self)
      class(joint_type), intent(in) :: self
      is_weld = self%place == place_at_point .and. self%keeps_angle
   end function is_weld

   !> Whether it is a coupler, which has no points.
   pure logical function is_coupler(self)
      class(joint_type), intent(in) :: self
      is_coupler = allocated(self%terms)
   end function is_coupler

   !> What makes the steps of an analysis more exact: those of a given length do not follow the tolerance.
   pure function finer(self) result(text)
      class(dynamics_type), intent(in) :: self
      character(:), allocatable :: text
      text = 'a smaller TOLERANCE'
      if (self%fixed_step > 0.0_wp) text = 'a smaller FIXED STEP'
   end function finer

   !> Whether the law of a part depends on time alone. True without a law.
   pure logical function is_of_time(self)
      class(load_part_type), intent(in) :: self
      is_of_time = .not. self%driven
      if (self%driven) is_of_time = all(self%quantities%kind == 0)
   end function is_of_time

   !> Whether a part is a constant force, which may grow from zero in *STATICS.
   pure logical function is_constant(self)
      class(load_part_type), intent(in) :: self
      is_constant = self%driven .and. .not. (self%stiffness > 0.0_wp .or. self%damping > 0.0_wp)
      if (is_constant) is_constant = self%law%is_constant()
   end function is_constant

end module limber_model_model
