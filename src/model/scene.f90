!> The model: bodies, points, joints, drivers, loads and what is asked for. Constant once it is built; it knows
!> neither the deck's text nor any state. Floor: model.
module limber_model_scene
   use limber_base_kinds, only: wp
   use limber_base_names, only: name_index_type
   use limber_deck_expression, only: expression_type
   use limber_flex_mesh, only: beam_type, field_type
   use limber_flex_reduced, only: reduced_type
   use limber_flex_reduction, only: reduction_type
   implicit none
   private
   public :: model_type, body_type, point_type, joint_type, driver_type, force_type, torque_type, spring_type
   public :: dynamics_type, accuracy_type, channel_type, quantity_type, units_type

   !> Kinds of bodies: a point mass has a position only, the others a floating frame too
   integer, parameter, public :: body_point = 1, body_rigid = 2, body_flexible = 3
   !> Kinds of joints
   integer, parameter, public :: joint_revolute = 1, joint_point_on_line = 2
   !> Index that stands for the ground where a body is expected
   integer, parameter, public :: ground = 0

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
      !> Largest distance between two of its points or nodes [length]
      real(wp) :: size = 0.0_wp
      !> Largest entry of its coordinates' shapes [1/sqrt(mass)]
      real(wp) :: largest_shape = 0.0_wp
      !> The beam, what was chosen of it, and its shapes at the nodes; of flexible bodies only
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(field_type) :: field
      !> Indices of the points at a beam's two ends
      integer :: start_point = 0, end_point = 0
   end type body_type

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
   end type point_type

   !> A joint between two points
   type :: joint_type
      character(:), allocatable :: name
      !> joint_revolute or joint_point_on_line
      integer :: kind = joint_revolute
      !> Indices of the two points
      integer :: points(2) = 0
      !> Direction of the line in the second body's frame [rad]
      real(wp) :: angle = 0.0_wp
   end type joint_type

   !> An angle of a body prescribed in time
   type :: driver_type
      character(:), allocatable :: name
      !> Index of the body
      integer :: body = 0
      !> Angle as a function of t [rad]
      type(expression_type) :: law
   end type driver_type

   !> A dead force at a point
   type :: force_type
      character(:), allocatable :: name
      !> Index of the point
      integer :: point = 0
      !> Its components along the fixed axes as functions of t (2) [force]
      type(expression_type) :: law(2)
   end type force_type

   !> A torque on a body
   type :: torque_type
      character(:), allocatable :: name
      !> Index of the body
      integer :: body = 0
      !> Function of t [force length]
      type(expression_type) :: law
   end type torque_type

   !> A spring and a damper between two points
   type :: spring_type
      character(:), allocatable :: name
      !> Indices of the two points
      integer :: points(2) = 0
      !> Stiffness [force/length], free length [length], damping [force time/length]
      real(wp) :: stiffness = 0.0_wp, length = 0.0_wp, damping = 0.0_wp
   end type spring_type

   !> A quantity that a channel's expression asks for
   type :: quantity_type
      !> Index into the table of quantities
      integer :: kind = 0
      !> Index of the point, body, joint, driver or spring that it is asked of
      integer :: of = 0
   end type quantity_type

   !> A requested channel: an expression of quantities
   type :: channel_type
      character(:), allocatable :: name
      !> Text of its expression, and its units
      character(:), allocatable :: long_name, units
      type(expression_type) :: expression
      !> What each slot of the expression stands for
      type(quantity_type), allocatable :: quantities(:)
   end type channel_type

   !> What a dynamic analysis is asked for
   type :: dynamics_type
      !> True if the deck asks for one
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

   !> What is to be known of the error of the results
   type :: accuracy_type
      !> True if the error of each channel is to be estimated
      logical :: estimate = .false.
   end type accuracy_type

   !> Names of the units that the deck's numbers are in; they label results only
   type :: units_type
      character(:), allocatable :: length, time, mass
   end type units_type

   !> Numbers of what has been added to the lists of a model, which may be longer while it is built
   type :: counts_type
      integer :: bodies = 0, points = 0, joints = 0, drivers = 0, forces = 0, torques = 0, springs = 0, channels = 0
   end type counts_type

   !> The whole model
   type :: model_type
      !> Text of *HEADING
      character(:), allocatable :: heading
      type(units_type) :: units
      !> Acceleration of gravity (2) [length/time^2]
      real(wp) :: gravity(2) = 0.0_wp
      type(body_type), allocatable :: bodies(:)
      type(point_type), allocatable :: points(:)
      type(joint_type), allocatable :: joints(:)
      type(driver_type), allocatable :: drivers(:)
      type(force_type), allocatable :: forces(:)
      type(torque_type), allocatable :: torques(:)
      type(spring_type), allocatable :: springs(:)
      type(channel_type), allocatable :: channels(:)
      !> True if the coordinates of all bodies are to be sampled, to be drawn
      logical :: motion = .false.
      type(dynamics_type) :: dynamics
      type(accuracy_type) :: accuracy
      !> Characteristic length: the largest size of a body or distance between guessed places [length]
      real(wp) :: length = 0.0_wp
      !> Of use while the model is built: lengths of the lists, and where in them a name stands: 'body rod', 'point rod.end', ...
      type(counts_type) :: counts
      type(name_index_type) :: names
   end type model_type

end module limber_model_scene
