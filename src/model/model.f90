!> Types of the model: bodies, points, joints, drivers, loads, requests. Constant once it is built; it knows neither the deck's text
!> nor any state. Floor: model.
module limber_model_model
   use limber_base_kinds, only: wp, long
   use limber_base_names, only: name_index_type
   use limber_deck_expression, only: expression_type
   use limber_deck_joint_kinds, only: joint_revolute
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
   public :: model_type, body_type, whole_type, point_type, joint_type, term_type, driver_type
   public :: deflection_type
   public :: load_part_type, distributed_load_type, named_load_type, scalar_type
   public :: dynamics_type, analysis_step_type, channel_type, quantity_type, dimension_type, units_type

   !> Kinds of bodies: a point mass has a position only, the others a floating frame too
   integer, parameter, public :: body_point = 1, body_rigid = 2, body_flexible = 3
   !> Kinds of joint coordinates that couplers and drivers know: the angle of a body's frame, of the first section of a joint in
   !> the second, the place of the first point of a joint along its line
   integer, parameter, public :: coordinate_angle = 1, coordinate_joint_angle = 2, coordinate_displacement = 3
   !> What a driver drives: the angle of a body, or of a joint, the distance of two points, the place along the line of a joint,
   !> the coordinates of a point
   integer, parameter, public :: driver_angle = 1, driver_joint_angle = 2, driver_distance = 3, driver_displacement = 4, &
      & driver_x = 5, driver_y = 6
   !> Kinds of analyses
   integer, parameter, public :: step_kinematics = 1, step_inverse = 2, step_statics = 3, step_modes = 4, step_dynamics = 5
   !> What a static analysis does where the equilibrium turns unstable
   integer, parameter, public :: leave_unstable = 1, stay_unstable = 2, stop_unstable = 3
   !> Velocities that a dynamic analysis starts with: those at the end of the one before, none, those of the deck
   integer, parameter, public :: velocities_kept = 1, velocities_none = 2, velocities_of_deck = 3
   !> Index that stands for the ground where a body is expected
   integer, parameter, public :: ground = 0

   !> What a part of a load acts along: the displacement of P1 along a fixed axis, relative to P2 if there is one; P1 itself along an axis
   !> of its section; the distance of the points; the coordinate of P1 from P2 along an axis of the section at P2; the angle of the
   !> section at P1 less that at P2
   integer, parameter, public :: along_axis = 1, along_follower = 2, along_distance = 3, along_slide = 4, along_angle = 5
   !> Kinds of loads that the deck names
   integer, parameter, public :: load_force = 1, load_torque = 2, load_spring = 3, load_rotational = 4, load_bushing = 5, &
      & load_distributed = 6, load_friction = 7
   !> Most things that the law of a load depends on
   integer, parameter, public :: most_slots = 15
   !> Kinds of summaries of a channel, and their names
   integer, parameter, public :: summary_first = 1, summary_last = 2, summary_minimum = 3, summary_maximum = 4, &
      & summary_mean = 5, summary_rms = 6
   character(7), parameter, public :: summary_names(6) = [character(7) :: 'first', 'last', 'minimum', 'maximum', 'mean', 'rms']
   !> Instead of a quantity of the table: elongation and rate of the spring whose law it is
   integer, parameter, public :: own_elongation = -1, own_rate = -2

   !> Dimension of a number
   type :: dimension_type
      !> Exponents of length, time and mass, and of angles
      integer :: exponents(3) = 0, turns = 0
      !> True if it may be any; true for a moment, which is no energy
      logical :: open = .false., moment = .false.
   end type dimension_type

   !> A quantity that an expression asks for
   type :: quantity_type
      !> Index into the table of quantities; 0: the time; or own_elongation, own_rate
      integer :: kind = 0
      !> Index of what it is asked of: a point, body, joint, driver or named load
      integer :: of = 0
      !> True if that is a named load
      logical :: of_load = .false.
      !> True if that is a coupler, of the joints
      logical :: of_coupler = .false.
      !> Dimension: exponents of length, time and mass; true for an angle or its rate
      integer :: dimension(3) = 0
      logical :: angular = .false.
   end type quantity_type

   !> A body, with the first guess of its place and motion
   type :: body_type
      !> Name as the deck writes it
      character(:), allocatable :: name
      !> body_point, body_rigid or body_flexible
      integer :: kind = body_rigid
      !> What the time loop needs
      type(reduced_type) :: reduced
      !> Guess of the frame's origin [length], its angle [rad], and their rates
      real(wp) :: position(2) = 0.0_wp, angle = 0.0_wp, velocity(2) = 0.0_wp, spin = 0.0_wp
      !> Which of them the deck gives: X, Y, ANGLE, VX, VY, SPIN
      logical :: given(6) = .false.
      !> Largest distance between two of its points or nodes [length]
      real(wp) :: size = 0.0_wp
      !> Largest entry of its coordinates' shapes [1/sqrt(mass)]
      real(wp) :: largest_shape = 0.0_wp
      !> The beam, what was chosen of it, and its shapes at the nodes; of flexible bodies only
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(displacement_field_type) :: field
      !> Functions of its basis that were left out because they depend on others; empty if none were
      character(:), allocatable :: note
      !> Parts of the critical damping of its modes as it is held (n), allocated if it is damped by its modes; Rayleigh's factors of
      !> mass and stiffness [1/time], [time]
      real(wp), allocatable :: ratio(:)
      real(wp) :: rayleigh(2) = 0.0_wp
      !> Indices of the points at a beam's two ends
      integer :: start_point = 0, end_point = 0
      !> True for a frame; its mesh, what was chosen of it, and its shapes at the nodes (3, nodes, n)
      logical :: is_frame = .false.
      type(frame_type) :: mesh
      !> Numbers of its members in the deck (members)
      integer, allocatable :: member_numbers(:)
      type(frame_choice_type) :: frame_choice
      real(wp), allocatable :: shape(:, :, :)
      !> Cross-section of each member, of a beam its only one: area [length^2], second moment of area [length^4], distances from the
      !> axis of the extreme fibres to the left and to the right [length], zero if not known (4, members)
      real(wp), allocatable :: strength(:, :)
      !> The same along an exact beam, and its second moment of area as the beam is curved; otherwise with unallocated values
      type(profile_type) :: fibres
      !> Internal forces at the sections that are asked for: those of points, then, if an envelope is, those along the whole body
      type(recovery_type) :: recovery
      logical :: envelope = .false.
      !> Number of the sections of points
      integer :: point_sections = 0
      !> What a beam or frame lacks for want of shear: of its first frequency, or of its deflection at rest, relative; the first body of
      !> a whole has it. Number of the member of a frame that has most of it
      real(wp) :: unsheared = 0.0_wp
      integer :: shortest = 0
      !> Of a flexible beam the first one with the same reduction, maybe itself
      integer :: twin = 0
      !> Of a piece of a beam in segments: which of the model's wholes it is a part of; else 0
      integer :: whole = 0
   end type body_type

   !> A beam of the deck that is divided into pieces, bodies of their own that are welded together. Its name stands for the first
   !> of them, whose frame is that of the whole beam if it is clamped at its start. Or a frame of exact beams: the section at the
   !> start of its first member carries its axes.
   type :: whole_type
      character(:), allocatable :: name
      !> First and last piece
      integer :: first = 0, last = 0
      !> Undeformed length; coordinate along the beam where its frame begins [length]
      real(wp) :: length = 0.0_wp, origin = 0.0_wp
      !> Whether the frame of the whole beam is the section at its start; else it lies along the chord
      logical :: clamped = .false.
      !> Welds between the pieces
      integer :: inner = 0
      !> Of a frame: numbers of its members in the deck, place of the start (2, members) [length] and direction [rad] of each in the
      !> axes of the frame
      integer, allocatable :: member_numbers(:)
      real(wp), allocatable :: place(:, :), lean(:)
   end type whole_type

   !> A named point of a body, or of the ground
   type :: point_type
      !> Name of the body and of the point: 'rod.middle'
      character(:), allocatable :: name
      !> Index of the body, or `ground`
      integer :: body = ground
      !> Undeformed place in the body frame (2) [length]; of a ground point its place
      real(wp) :: p0(2) = 0.0_wp
      !> Displacement (2,n) and rotation of the section (n) for each coordinate of the body
      real(wp), allocatable :: phi(:, :), psi(:)
      !> True of a point or direction of an exact beam, whose section turns by psi.eta; what the stations of the beam give to the
      !> place of the point (stations) [length]
      logical :: exact = .false.
      real(wp), allocatable :: reach(:)
      !> True for a direction of the section, which does not move with the origin of the frame: p0 a unit vector, phi what psi
      !> makes of it; the system makes these of points
      logical :: direction = .false.
      !> Of a point of a beam or frame: its member, how many members meet there, and its coordinate along that one [length]
      integer :: member = 0, meeting = 1
      real(wp) :: along = 0.0_wp
      !> Of a point of a frame of exact beams: angle of its member in the frame, whose axes the axes of the point are parallel to [rad]
      real(wp) :: lean = 0.0_wp
      !> Index among the sections of its body where internal forces are asked for; 0: none are
      integer :: section = 0
   end type point_type

   !> A load along a member whose point stands for it, for the internal forces that it makes
   type :: distributed_load_type
      !> Index of the point, and of its member
      integer :: point = 0, member = 1
      !> Where it begins and ends [length]
      real(wp) :: ends(2) = 0.0_wp
      !> Of the coordinate s along the beam or member, where the body begins there [length], what is added [force/length]; and the
      !> whole [force]
      type(expression_type) :: law
      real(wp) :: start = 0.0_wp, added = 0.0_wp, total = 1.0_wp
      !> Number of Gauss's station between the ends whose part of the load it is, by Lagrange's polynomial; 0: all of it
      integer :: station = 0
   end type distributed_load_type

   !> A term of a coupler
   type :: term_type
      real(wp) :: coefficient = 0.0_wp
      !> Kind of joint coordinate, and index of the body or joint
      integer :: kind = 0, of = 0
   end type term_type

   !> A joint between two points
   type :: joint_type
      character(:), allocatable :: name
      !> Row of the table of kinds: joint_revolute, ...
      integer :: kind = joint_revolute
      !> Indices of the two points
      integer :: points(2) = 0
      !> Direction of the line in the second body's section [rad]
      real(wp) :: angle = 0.0_wp
      !> Angle of the first section from the second, of weld and translational joint [rad]; length of a rod; where the deck does
      !> not say, that of the first guess
      real(wp) :: turn = 0.0_wp, length = 0.0_wp
      logical :: has_turn = .false., has_length = .false.
      !> Radii of gears, wheels, or of a pinion [length]
      real(wp) :: radius(2) = 0.0_wp
      !> True if both turn in the same direction: gears inside one another, wheels of an open belt
      logical :: same_direction = .false.
      !> The curve that a point stays on
      type(curve_type) :: curve
      !> Whether it holds the beam on either side across its axis at the start: what hangs on the beam alone, or slides across it,
      !> does not; and whether it keeps it from turning though it does not hold it
      logical :: bears(2) = .true., guides(2) = .false.
      !> Terms of a coupler, and what their sum is in time; without a law, that of the first guess
      type(term_type), allocatable :: terms(:)
      logical :: has_law = .false.
      type(expression_type) :: law
   end type joint_type

   !> A motion prescribed in time
   type :: driver_type
      character(:), allocatable :: name
      !> driver_angle, ...
      integer :: kind = driver_angle
      !> Index of the body, of the joint, of the points: what the kind needs
      integer :: body = 0, joint = 0, points(2) = 0
      !> What is prescribed as a function of t [rad or length], or one of its derivatives
      type(expression_type) :: law
      !> What the law is of: 0 the coordinate, 1 its velocity, 2 its acceleration
      integer :: level = 0
      !> Of levels 1 and 2: coordinate and velocity at the start
      real(wp) :: initial(2) = 0.0_wp
      !> Whether the deck says the first; else it is that of the first guess
      logical :: has_initial = .false.
      !> Integrals of the law
      type(integral_type) :: integral
   end type driver_type

   !> A part of a load: a force or torque along one scalar of the motion s, -k (s - origin) - c s' and a law times a factor
   type :: load_part_type
      !> What s is: along_axis, along_follower, along_distance, along_slide or along_angle
      integer :: along = 0
      !> Indices of one or two points: P1 and P2; the second may be 0
      integer :: points(2) = 0
      !> Angle of the axis; of the direction in the section at P1 (follower) or P2 (slide) [rad]
      real(wp) :: angle = 0.0_wp
      !> Free length or angle, k, c, and what the law is multiplied by
      real(wp) :: origin = 0.0_wp, stiffness = 0.0_wp, damping = 0.0_wp, factor = 1.0_wp
      !> Whether there is a law, and the law with what its slots stand for
      logical :: driven = .false.
      type(expression_type) :: law
      type(quantity_type), allocatable :: quantities(:)
   contains
      procedure :: is_of_time, is_constant
   end type load_part_type

   !> A load as the deck names it
   type :: named_load_type
      character(:), allocatable :: name
      !> load_force, load_torque, load_spring, load_rotational, load_bushing, load_distributed or load_friction
      integer :: kind = 0
      !> Its parts: first and last index in the list of the model
      integer :: first = 0, last = 0
   end type named_load_type

   !> A requested channel: an expression of quantities
   type :: channel_type
      character(:), allocatable :: name
      !> Text of its expression, and its units
      character(:), allocatable :: long_name, units
      type(dimension_type) :: dimension
      !> What its displacements and angles are measured from; empty if nothing is to be said
      character(:), allocatable :: reference
      type(expression_type) :: expression
      !> What each slot of the expression stands for
      type(quantity_type), allocatable :: quantities(:)
   end type channel_type

   !> A single number of a run: an expression of what channels were over its samples
   type :: scalar_type
      character(:), allocatable :: name
      !> Text of its expression, and its units
      character(:), allocatable :: long_name, units
      type(expression_type) :: expression
      !> What each slot of the expression stands for: one of the kinds of summaries, and the index of the channel
      integer, allocatable :: summaries(:), channels(:)
   end type scalar_type

   !> What an analysis in time is asked for, a dynamic one above all
   type :: dynamics_type
      !> True if the deck asks for an analysis
      logical :: wanted = .false.
      !> First and last time
      real(wp) :: start = 0.0_wp, end = 0.0_wp
      !> Number of equal intervals between samples
      integer :: outputs = 100
      !> Local error allowed in a step, relative to each scale
      real(wp) :: tolerance = 1.0e-6_wp
      !> Name of the integrator; and, where the deck leaves it to limber, why it is that one
      character(:), allocatable :: integrator, reason
      !> Spectral radius at infinity of ALPHA
      real(wp) :: spectral_radius = 0.8_wp
      !> First and largest step; zero: chosen, unbounded
      real(wp) :: initial_step = 0.0_wp, maximum_step = 0.0_wp
      !> Length of every step; zero: chosen by the error
      real(wp) :: fixed_step = 0.0_wp
      !> Largest number of steps
      integer :: maximum_steps = 100000000
   end type dynamics_type

   !> A coordinate of a beam that is given at the start
   type :: deflection_type
      !> Index of the body, and of its coordinate
      integer :: body = 0, coordinate = 0
      !> Its value [length sqrt(mass)] and rate
      real(wp) :: value = 0.0_wp, rate = 0.0_wp
   end type deflection_type

   !> What the assembly is asked for
   type :: assembly_choice_type
      !> Rotation from the guess to the first position above which there is a warning [rad]
      real(wp) :: largest_turn = 0.5_wp
      !> Whether deflections start in equilibrium with loads and inertia
      logical :: static_deflections = .false.
      !> Whether they start with the rates by which that goes on with the motion
      logical :: following = .false.
      !> Whether what hangs, or is held by what is known, is solved without unknowns and multipliers
      logical :: elimination = .true.
      !> Deflections that are given; all others start at zero
      type(deflection_type), allocatable :: deflections(:)
   end type assembly_choice_type
   !> An analysis: a step of the deck, which starts from the end of the one before
   type :: analysis_step_type
      !> One of the kinds of analyses
      integer :: kind = step_dynamics
      !> Name in the results, and index of the deck's block
      character(:), allocatable :: name
      integer :: block = 0
      !> First and last time, samples; of a dynamic analysis all that it is asked for
      type(dynamics_type) :: dynamics
      !> Dynamics: the velocities at the start
      integer :: velocities = velocities_kept
      !> Kinematics and inverse dynamics: whether deflections are in equilibrium at each sample, or held
      logical :: static_deflections = .false.
      !> Statics: whether constant loads grow from zero, and what is done with an unstable equilibrium
      logical :: ramp = .false.
      integer :: instability = leave_unstable
      !> Statics: speed of a steady rotation of everything at the end [rad/time], and its centre [length]
      real(wp) :: rotation = 0.0_wp, centre(2) = 0.0_wp
      !> Modes: how many, and whether they are damped
      integer :: modes = 10
      logical :: damped = .false.
   end type analysis_step_type

   !> What is to be known of the error of the results
   type :: accuracy_type
      !> True if the error of each channel is to be estimated
      logical :: estimate = .false.
      !> Error asked for, relative to the largest value of each channel; zero: none
      real(wp) :: target = 0.0_wp
   end type accuracy_type

   !> Names of the units that the deck's numbers are in; they label results only
   type :: units_type
      character(:), allocatable :: length, time, mass
   end type units_type

   !> Numbers of what has been added to the lists of a model, which may be longer while it is built
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
      !> All loads by their names, and their parts in the same order
      type(named_load_type), allocatable :: loads(:)
      type(load_part_type), allocatable :: load_parts(:)
      !> While the model is built
      type(distributed_load_type), allocatable :: spreads(:)
      type(channel_type), allocatable :: channels(:)
      type(scalar_type), allocatable :: scalars(:)
      !> True if the coordinates of all bodies are to be sampled, to be drawn
      logical :: motion = .false.
      type(assembly_choice_type) :: assembly
      !> The analyses in order, none if not allocated; and the one that runs
      type(analysis_step_type), allocatable :: steps(:)
      type(dynamics_type) :: dynamics
      type(accuracy_type) :: accuracy
      !> Characteristic length: the largest size of a body or distance between guessed places [length]
      real(wp) :: length = 0.0_wp
      !> Of use while the model is built: lengths of the lists, and where in them a name stands: 'body rod', 'point rod.end', ...
      type(counts_type) :: counts
      type(name_index_type) :: names
   end type model_type

contains

   !> Whether the law of a part depends on nothing but the time. True without a law.
   pure logical function is_of_time(self)
      class(load_part_type), intent(in) :: self
      is_of_time = .not. self%driven
      if (self%driven) is_of_time = all(self%quantities%kind == 0)
   end function is_of_time

   !> Whether a part is a force that never changes, and may grow from zero in *STATICS.
   pure logical function is_constant(self)
      class(load_part_type), intent(in) :: self
      is_constant = self%driven .and. .not. (self%stiffness > 0.0_wp .or. self%damping > 0.0_wp)
      if (is_constant) is_constant = self%law%is_constant()
   end function is_constant

end module limber_model_model
