!> Scenes built in code, without a deck, and what the tests of the equations share: repeatable random numbers, laws in time,
!> stencils and Gauss points of their own, and a slider-crank.
module scenes
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type
   use limber_deck_keywords, only: load_language
   use limber_model_joint_kind, only: describe_joint
   use limber_deck_operations, only: first_function, function_names, op_add, op_constant, op_multiply, op_slot
   use limber_beam_plane_frame, only: frame_type, member_type, new_frame
   use limber_beam_frame_reduction, only: frame_choice_type, frame_point_shape, reduce_frame
   use limber_beam_beam_mesh, only: beam_type, new_support
   use limber_beam_reduced_body, only: rigid_reduced
   use limber_beam_beam_reduction, only: fidelity_exact, point_shape, exact_shape, reduce_beam, reduction_type
   use limber_model_model, only: body_flexible, body_point, body_rigid, body_type, driver_type, ground, joint_type, &
      & load_part_type, model_type, point_type, along_axis, along_distance, along_angle
   implicit none
   private
   !> Kinds of joints, by their words in the deck
   integer, parameter, public :: joint_revolute = 1, joint_point_on_line = 2, joint_translational = 3, joint_weld = 4, &
      & joint_rod = 5, joint_curve = 6, joint_sliding = 7, joint_gear = 8, joint_rack = 9, joint_belt = 10, joint_coupler = 11
   character(14), parameter :: joint_words(10) = [character(14) :: 'REVOLUTE', 'POINT ON LINE', 'TRANSLATIONAL', 'WELD', 'ROD', &
      & 'POINT ON CURVE', 'SLIDING', 'GEAR', 'RACK', 'BELT']
   public :: describe, random, constant_law, wavy_law, ramp_law, gauss_point, gauss_weight, derivative, second_derivative
   public :: empty_model, add_rigid, add_point_mass, add_beam, add_place, add_beam_place, add_joint, join, add_driver, add_force
   public :: add_spring, add_torque
   public :: slider_crank, add_frame, add_frame_place, l_frame

   !> Five Gauss points on -1..1, exact to degree nine: places and weights
   real(wp), parameter, private :: near = sqrt(5.0_wp - 2.0_wp*sqrt(10.0_wp/7.0_wp))/3.0_wp
   real(wp), parameter, private :: far = sqrt(5.0_wp + 2.0_wp*sqrt(10.0_wp/7.0_wp))/3.0_wp
   real(wp), parameter :: gauss_point(5) = [-far, -near, 0.0_wp, near, far]
   real(wp), parameter :: gauss_weight(5) = [(322.0_wp - 13.0_wp*sqrt(70.0_wp))/900.0_wp, &
      & (322.0_wp + 13.0_wp*sqrt(70.0_wp))/900.0_wp, 128.0_wp/225.0_wp, (322.0_wp + 13.0_wp*sqrt(70.0_wp))/900.0_wp, &
      & (322.0_wp - 13.0_wp*sqrt(70.0_wp))/900.0_wp]

   integer, parameter :: seed_modulus = 2147483647
   integer, save :: seed = 20240229

contains

   !> A number between -1 and 1; the same sequence in every run.
   real(wp) function random()
      integer, parameter :: long = selected_int_kind(18)
      seed = int(modulo(16807_long*int(seed, long), int(seed_modulus, long)))
      random = 2.0_wp*real(seed, wp)/real(seed_modulus, wp) - 1.0_wp
   end function random

   !> First derivative from values at -2h, -h, h, 2h: exact for polynomials to degree four.
   pure elemental real(wp) function derivative(left2, left, right, right2, h)
      real(wp), intent(in) :: left2, left, right, right2, h
      derivative = (8*(right - left) - (right2 - left2))/(12*h)
   end function derivative

   !> Second derivative from values at -2h, -h, 0, h, 2h: exact for polynomials to degree five.
   pure elemental real(wp) function second_derivative(left2, left, middle, right, right2, h)
      real(wp), intent(in) :: left2, left, middle, right, right2, h
      second_derivative = (16*((right - middle) + (left - middle)) - ((right2 - middle) + (left2 - middle)))/(12*h**2)
   end function second_derivative

   !> A law that does not change.
   function constant_law(value) result(law)
      real(wp), intent(in) :: value
      type(expression_type) :: law
      allocate (law%codes(1), source=op_constant)
      allocate (law%operands(1), source=1)
      allocate (law%constants(1), source=value)
      allocate (law%slots(0))
   end function constant_law

   !> a + b t + c sin(d t), as a postfix program.
   function wavy_law(a, b, c, d) result(law)
      real(wp), intent(in) :: a, b, c, d
      type(expression_type) :: law
      allocate (law%codes(12), source=[op_constant, op_constant, op_slot, op_multiply, op_add, op_constant, op_constant, op_slot, &
         & op_multiply, code_of('sin'), op_multiply, op_add])
      allocate (law%operands(12), source=[1, 2, 1, 0, 0, 3, 4, 1, 0, 0, 0, 0])
      allocate (law%constants(4), source=[a, b, c, d])
      allocate (law%slots(1))
      law%slots(1)%name = 't'
      law%slots(1)%argument = ''
   end function wavy_law

   !> a tanh(b (t - c)): as sudden as one likes, and smooth.
   function ramp_law(a, b, c) result(law)
      real(wp), intent(in) :: a, b, c
      type(expression_type) :: law
      allocate (law%codes(8), source=[op_constant, op_constant, op_slot, op_constant, op_add, op_multiply, code_of('tanh'), &
         & op_multiply])
      allocate (law%operands(8), source=[1, 2, 1, 3, 0, 0, 0, 0])
      allocate (law%constants(3), source=[a, b, -c])
      allocate (law%slots(1))
      law%slots(1)%name = 't'
      law%slots(1)%argument = ''
   end function ramp_law

   !> Code of a function of the deck's language.
   pure integer function code_of(name) result(code)
      character(*), intent(in) :: name
      do code = first_function, first_function + size(function_names) - 1
         if (function_names(code - first_function + 1) == name) return
      end do
   end function code_of

   !> A model of nothing.
   function empty_model(length) result(model)
      !> Characteristic length
      real(wp), intent(in) :: length
      type(model_type) :: model
      model%length = length
      allocate (model%bodies(0), model%points(0), model%joints(0), model%drivers(0), model%channels(0))
      allocate (model%load_parts(0), model%loads(0))
   end function empty_model

   !> Adds a rigid body; returns its index.
   function add_rigid(model, name, mass, inertia, centre, position, angle) result(index)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      real(wp), intent(in) :: mass, inertia, centre(2), position(2), angle
      integer :: index
      type(body_type) :: body
      body%name = name
      body%kind = body_rigid
      body%reduced = rigid_reduced(mass, inertia, centre)
      body%position = position
      body%angle = angle
      body%size = model%length
      index = add_body(model, body)
   end function add_rigid

   !> Adds a point mass; returns its index.
   function add_point_mass(model, name, mass, position) result(index)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      real(wp), intent(in) :: mass, position(2)
      integer :: index
      type(body_type) :: body
      body%name = name
      body%kind = body_point
      body%reduced = rigid_reduced(mass, 0.0_wp, [0.0_wp, 0.0_wp])
      body%position = position
      index = add_body(model, body)
   end function add_point_mass

   !> Adds a beam; returns its index.
   function add_beam(model, name, beam, choice, position, angle, error) result(index)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      real(wp), intent(in) :: position(2), angle
      type(error_type), allocatable, intent(out) :: error
      integer :: index
      type(body_type) :: body
      body%name = name
      body%kind = body_flexible
      body%beam = beam
      body%choice = choice
      if (choice%fidelity == fidelity_exact .and. .not. allocated(choice%exact%kinks)) then
         body%choice%exact%angles = choice%bending
         body%choice%exact%support = choice%support
         body%choice%exact%origin = choice%origin
         allocate (body%choice%exact%kinks(0), body%choice%exact%steps(0), body%choice%exact%corners(0))
      end if
      call reduce_beam(beam, body%choice, body%reduced, body%field, error)
      body%largest_shape = max(maxval(abs(body%field%w)), maxval(abs(body%field%u)))
      body%size = beam%length
      body%position = position
      body%angle = angle
      index = add_body(model, body)
   end function add_beam

   !> Adds a frame; returns its index.
   function add_frame(model, name, frame, choice, position, angle, error) result(index)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      type(frame_type), intent(in) :: frame
      type(frame_choice_type), intent(in) :: choice
      real(wp), intent(in) :: position(2), angle
      type(error_type), allocatable, intent(out) :: error
      integer :: index
      type(body_type) :: body
      body%name = name
      body%kind = body_flexible
      body%is_frame = .true.
      body%mesh = frame
      body%frame_choice = choice
      call reduce_frame(frame, choice, body%reduced, body%shape, error)
      body%largest_shape = maxval(abs(body%shape(1:2, :, :)))
      body%size = maxval(frame%place) - minval(frame%place)
      body%position = position
      body%angle = angle
      index = add_body(model, body)
   end function add_frame

   !> A soft frame of two members at an angle, its first corner clamped, with a mass that also has a moment of inertia at the corner
   !> and another at the tip.
   function l_frame() result(frame)
      type(frame_type) :: frame
      type(member_type) :: members(2)
      members(1) = member_type(ends=[1, 2], ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, divisions=5)
      members(2) = member_type(ends=[3, 2], ea=3.0e3_wp, ei=1.2_wp, rho_a=0.6_wp, divisions=4)
      frame = new_frame(reshape([0.0_wp, 0.0_wp, 0.7_wp, 0.3_wp, 0.6_wp, 1.1_wp], [2, 3]), members)
      frame%free(:, 1) = .false.
      frame%mass(:, 2) = frame%mass(:, 2) + [0.3_wp, 0.3_wp, 0.02_wp]
      frame%mass(:, 3) = frame%mass(:, 3) + [0.1_wp, 0.1_wp, 0.03_wp]
   end function l_frame

   !> Adds the point at x along a member of a frame; returns its index.
   function add_frame_place(model, name, body, member, x) result(index)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: body, member
      real(wp), intent(in) :: x
      integer :: index, first
      real(wp), allocatable :: phi(:, :), psi(:)
      real(wp) :: p0(2)
      associate (mesh => model%bodies(body)%mesh)
         first = mesh%first(member)
         p0 = mesh%place(:, mesh%ends(1, first)) + x*mesh%axis(:, first)
      end associate
      call frame_point_shape(model%bodies(body)%mesh, model%bodies(body)%shape, member, x, phi, psi)
      index = add_place(model, name, body, p0, phi, psi)
   end function add_frame_place

   !> Appends by hand: intrinsic array constructors of types with deep components cost more than they save.
   integer function add_body(model, body) result(index)
      type(model_type), intent(inout) :: model
      type(body_type), intent(in) :: body
      type(body_type), allocatable :: longer(:)
      index = size(model%bodies) + 1
      allocate (longer(index))
      longer(:index - 1) = model%bodies
      longer(index) = body
      call move_alloc(longer, model%bodies)
   end function add_body

   !> Adds a point at p0 of a body without coordinates, or of the ground; returns its index. Shapes may be given.
   function add_place(model, name, body, p0, phi, psi) result(index)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: body
      real(wp), intent(in) :: p0(2)
      real(wp), intent(in), optional :: phi(:, :), psi(:)
      integer :: index, n
      type(point_type), allocatable :: longer(:)
      n = 0
      if (body /= ground) n = model%bodies(body)%reduced%n
      index = size(model%points) + 1
      allocate (longer(index))
      longer(:index - 1) = model%points
      longer(index)%name = name
      longer(index)%body = body
      longer(index)%p0 = p0
      allocate (longer(index)%phi(2, n), longer(index)%psi(n))
      longer(index)%phi = 0.0_wp
      longer(index)%psi = 0.0_wp
      if (present(phi)) longer(index)%phi = phi
      if (present(psi)) longer(index)%psi = psi
      call move_alloc(longer, model%points)
   end function add_place

   !> Adds the point at x along a beam; returns its index.
   function add_beam_place(model, name, body, x) result(index)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: body
      real(wp), intent(in) :: x
      integer :: index
      real(wp), allocatable :: phi(:, :), psi(:), reach(:)
      if (model%bodies(body)%reduced%is_exact) then
         call exact_shape(model%bodies(body)%reduced%exact, x, phi, psi, reach)
      else
         call point_shape(model%bodies(body)%field, x, phi, psi)
      end if
      index = add_place(model, name, body, [x - model%bodies(body)%choice%origin, 0.0_wp], phi, psi)
      model%points(index)%exact = model%bodies(body)%reduced%is_exact
      if (model%points(index)%exact) call move_alloc(reach, model%points(index)%reach)
   end function add_beam_place

   !> Adds a joint between two points; `angle` is that of a line in the second body's frame.
   subroutine add_joint(model, name, kind, first, second, angle)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: kind, first, second
      real(wp), intent(in), optional :: angle
      type(joint_type), allocatable :: longer(:)
      integer :: n
      n = size(model%joints) + 1
      allocate (longer(n))
      longer(:n - 1) = model%joints
      longer(n)%name = name
      longer(n)%points = [first, second]
      if (present(angle)) longer(n)%angle = angle
      call describe(longer(n), kind)
      call move_alloc(longer, model%joints)
   end subroutine add_joint

   !> Writes the equations of a joint by its kind and sizes; a coupler has terms.
   subroutine describe(joint, kind)
      type(joint_type), intent(inout) :: joint
      integer, intent(in) :: kind
      if (kind == joint_coupler) then
         allocate (joint%terms(0))
         return
      end if
      call load_language()
      if (allocated(joint%functions)) deallocate (joint%functions)
      call describe_joint(joint_words(kind), joint)
   end subroutine describe

   !> Adds a joint and its two points; a place on a beam is that along it.
   subroutine join(model, name, kind, first, at, second, place, angle)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: kind, first, second
      real(wp), intent(in) :: at(2), place(2)
      real(wp), intent(in), optional :: angle
      integer :: points(2)
      points(1) = place_on(first, at)
      points(2) = place_on(second, place)
      call add_joint(model, name, kind, points(1), points(2), angle)

   contains

      integer function place_on(body, p) result(index)
         integer, intent(in) :: body
         real(wp), intent(in) :: p(2)
         logical :: flexible
         flexible = .false.
         if (body /= ground) flexible = model%bodies(body)%kind == body_flexible
         if (flexible) then
            index = add_beam_place(model, name, body, p(1))
         else
            index = add_place(model, name, body, p)
         end if
      end function place_on

   end subroutine join

   !> Prescribes the angle of a body.
   subroutine add_driver(model, name, body, law)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: body
      type(expression_type), intent(in) :: law
      type(driver_type), allocatable :: longer(:)
      integer :: n
      n = size(model%drivers) + 1
      allocate (longer(n))
      longer(:n - 1) = model%drivers
      longer(n)%name = name
      longer(n)%body = body
      longer(n)%law = law
      call move_alloc(longer, model%drivers)
   end subroutine add_driver

   !> Puts a dead force on a point: two loads, along x and y.
   subroutine add_force(model, point, x, y)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: point
      type(expression_type), intent(in) :: x, y
      call add_part(model, along_axis, [point, 0], law=x)
      call add_part(model, along_axis, [point, 0], law=y)
      model%load_parts(size(model%load_parts))%angle = 0.5_wp*acos(-1.0_wp)
   end subroutine add_force

   !> Puts a spring between two points.
   subroutine add_spring(model, first, second, stiffness, length, damping)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: first, second
      real(wp), intent(in) :: stiffness, length, damping
      call add_part(model, along_distance, [first, second])
      associate (spring => model%load_parts(size(model%load_parts)))
         spring%stiffness = stiffness
         spring%origin = length
         spring%damping = damping
      end associate
   end subroutine add_spring

   !> Puts a torque on the frame of a body.
   subroutine add_torque(model, body, law)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: body
      type(expression_type), intent(in) :: law
      call add_part(model, along_angle, [add_place(model, 'torque', body, [0.0_wp, 0.0_wp]), 0], law=law)
   end subroutine add_torque

   !> Adds a part of a load without a name, by hand for the law's sake.
   subroutine add_part(model, along, points, law)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: along, points(2)
      !> Of the time
      type(expression_type), intent(in), optional :: law
      type(load_part_type), allocatable :: longer(:)
      integer :: n
      n = size(model%load_parts) + 1
      allocate (longer(n))
      longer(:n - 1) = model%load_parts
      longer(n)%along = along
      longer(n)%points = points
      longer(n)%driven = present(law)
      if (present(law)) then
         longer(n)%law = law
         allocate (longer(n)%quantities(size(law%slots)))
      end if
      call move_alloc(longer, model%load_parts)
   end subroutine add_part

   !> A driven slider-crank under weight, its rod rigid or of a fidelity with two bending and two axial coordinates.
   subroutine slider_crank(fidelity, ea, model, error)
      !> Fidelity of the rod, zero: rigid; its axial rigidity
      integer, intent(in) :: fidelity
      real(wp), intent(in) :: ea
      type(model_type), intent(out) :: model
      type(error_type), allocatable, intent(out) :: error
      type(reduction_type) :: choice
      real(wp), parameter :: length = 0.5_wp, rho_a = 0.6_wp, nil(2) = [0.0_wp, 0.0_wp], place(2) = [0.2_wp, 0.1_wp]
      integer :: crank, rod, slider
      model = empty_model(length)
      model%gravity = [0.0_wp, -9.81_wp]
      crank = add_rigid(model, 'crank', 0.4_wp, 2.0e-3_wp, [0.1_wp, 0.01_wp], nil, 0.9_wp)
      if (fidelity == 0) then
         rod = add_rigid(model, 'rod', rho_a*length, rho_a*length**3/12, [0.5_wp*length, 0.0_wp], place, -0.3_wp)
      else
         choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=2, geometric_elements=2, &
            & fidelity=fidelity)
         rod = add_beam(model, 'rod', beam_type(ea=ea, ei=1.2_wp, rho_a=rho_a, length=length, elements=12), choice, place, &
            & -0.3_wp, error)
         if (allocated(error)) return
      end if
      slider = add_point_mass(model, 'slider', 0.3_wp, [0.6_wp, 0.0_wp])
      call join(model, 'axle', joint_revolute, crank, nil, ground, nil)
      call join(model, 'crank-pin', joint_revolute, rod, nil, crank, [0.2_wp, 0.0_wp])
      call join(model, 'wrist-pin', joint_revolute, rod, [length, 0.0_wp], slider, nil)
      call join(model, 'slide', joint_point_on_line, slider, nil, ground, nil, 0.05_wp)
      call add_driver(model, 'motor', crank, wavy_law(0.9_wp, 20.0_wp, 0.3_wp, 5.0_wp))
   end subroutine slider_crank

end module scenes
