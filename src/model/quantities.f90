!> Table of the quantities of *OUTPUT and of laws. Source of the model builder, `limber help OUTPUT` and the manual. Floor: model.
module limber_model_quantities
   use limber_base_text, only: newline
   implicit none
   private
   public :: quantity_spec_type, quantities, quantity_help, quantity_manual, is_internal_force, partners_of

   !> Kinds of objects of a quantity
   integer, parameter, public :: of_point = 1, of_body = 2, of_beam_point = 3, of_beam = 4, of_joint = 5, of_driver = 6, &
      & of_system = 7, of_spring = 8, of_translational = 9, of_turner = 10, of_pusher = 11, of_powered = 12, &
      & of_flexible_point = 13, of_section = 14, of_coupler = 15, of_control = 16, of_state = 17, &
      & of_contact = 18

   !> Index of each quantity in the table
   integer, parameter, public :: quantity_x = 1, quantity_y = 2, quantity_vx = 3, quantity_vy = 4, quantity_ax = 5, &
      & quantity_ay = 6, quantity_angle = 7, quantity_spin = 8, quantity_deflection = 9, quantity_length = 10, &
      & quantity_force_x = 11, quantity_force_y = 12, quantity_torque = 13, quantity_kinetic = 14, &
      & quantity_potential = 15, quantity_work = 16, quantity_u1 = 17, quantity_u2 = 18, quantity_rotation = 19, &
      & quantity_tension = 20, &
      & quantity_force_1 = 21, quantity_force_2 = 22, quantity_moment = 23, quantity_joint_angle = 24, &
      & quantity_joint_spin = 25, quantity_displacement = 26, quantity_sliding_speed = 27, &
      & quantity_force = 28, quantity_power = 29, quantity_elongation = 30, quantity_rate = 31, &
      & quantity_axial_force = 32, quantity_shear_force = 33, quantity_bending_moment = 34, quantity_stress_top = 35, &
      & quantity_stress_bottom = 36, quantity_momentum_x = 37, quantity_momentum_y = 38, quantity_angular_momentum = 39, &
      & quantity_coupling = 40, quantity_output = 41, quantity_state = 42, quantity_closed = 43, &
      & quantity_lost = 44

   !> One row of the table
   type :: quantity_spec_type
      !> Name in the deck
      character(16) :: name
      !> Kind of its object, `of_...`
      integer :: of
      !> Dimension: exponents of length, time and mass
      integer :: dimension(3)
      !> True for an angle, whose unit is written rad
      logical :: angular
      !> Description in one line
      character(100) :: meaning
   end type quantity_spec_type

   type(quantity_spec_type), parameter :: quantities(44) = [ &
      & quantity_spec_type('x', of_point, [1, 0, 0], .false., 'position of a point along the fixed x axis'), &
      & quantity_spec_type('y', of_point, [1, 0, 0], .false., 'position of a point along the fixed y axis'), &
      & quantity_spec_type('vx', of_point, [1, -1, 0], .false., 'velocity of a point along x'), &
      & quantity_spec_type('vy', of_point, [1, -1, 0], .false., 'velocity of a point along y'), &
      & quantity_spec_type('ax', of_point, [1, -2, 0], .false., 'acceleration of a point along x'), &
      & quantity_spec_type('ay', of_point, [1, -2, 0], .false., 'acceleration of a point along y'), &
      & quantity_spec_type('angle', of_body, [0, 0, 0], .true., &
      &    'angle of a body''s frame from the x axis, accumulated over turns; of a driven one those of its law'), &
      & quantity_spec_type('spin', of_body, [0, -1, 0], .true., 'angular velocity of a body''s frame'), &
      & quantity_spec_type('deflection', of_beam_point, [1, 0, 0], .false., &
      &    'signed distance of a beam''s point from the chord through its ends, positive to the left'), &
      & quantity_spec_type('length', of_beam, [1, 0, 0], .false., 'undeformed length of a beam'), &
      & quantity_spec_type('force_x', of_pusher, [1, -2, 1], .false., &
      &    'force along x of a joint or bushing on its first body; with redundant joints that of least norm'), &
      & quantity_spec_type('force_y', of_pusher, [1, -2, 1], .false., &
      &    'force along y of a joint or bushing on its first body; with redundant joints that of least norm'), &
      & quantity_spec_type('torque', of_turner, [2, -2, 1], .false., &
      &    'torque of a driver that drives an angle; of a rotational spring, or a stop, on its first body'), &
      & quantity_spec_type('kinetic_energy', of_system, [2, -2, 1], .false., &
      &    'kinetic energy of the whole: kinetic_energy(system)'), &
      & quantity_spec_type('potential_energy', of_system, [2, -2, 1], .false., &
      &    'energy of beams, springs and weight of the whole: potential_energy(system)'), &
      & quantity_spec_type('work', of_system, [2, -2, 1], .false., &
      &    'work of drivers, forces and torques, less that of dampers, in this motion; 0 at rest: work(system)'), &
      & quantity_spec_type('u1', of_flexible_point, [1, 0, 0], .false., &
      &    'displacement of a point of a beam or frame along the first axis of the body''s frame'), &
      & quantity_spec_type('u2', of_flexible_point, [1, 0, 0], .false., &
      &    'displacement of a point of a beam or frame along the second axis of the body''s frame'), &
      & quantity_spec_type('rotation', of_flexible_point, [0, 0, 0], .true., &
      &    'rotation of the section at a point of a beam or frame within the body''s frame'), &
      & quantity_spec_type('tension', of_translational, [1, -2, 1], .false., &
      &    'pull of a spring and its damper, or of a stop, on their points'), &
      & quantity_spec_type('force_1', of_joint, [1, -2, 1], .false., &
      &    'force of a joint on its first body along the first axis of the second body''s frame, as angle tells'), &
      & quantity_spec_type('force_2', of_joint, [1, -2, 1], .false., 'the same along the second axis'), &
      & quantity_spec_type('moment', of_pusher, [2, -2, 1], .false., &
      &    'moment of a joint on its first body about its first point; torque of a bushing on its first body'), &
      & quantity_spec_type('joint_angle', of_joint, [0, 0, 0], .true., &
      &    'angle of a joint''s first section less that of the second, over turns; driven: those of the law'), &
      & quantity_spec_type('joint_spin', of_joint, [0, -1, 0], .true., 'its rate'), &
      & quantity_spec_type('displacement', of_joint, [1, 0, 0], .false., &
      &    'place of the first point along the line through the second, at its ANGLE; SLIDING: along the beam'), &
      & quantity_spec_type('sliding_speed', of_joint, [1, -1, 0], .false., 'its rate'), &
      & quantity_spec_type('force', of_driver, [1, -2, 1], .false., &
      &    'force of a driver that drives a length, positive where it lengthens'), &
      & quantity_spec_type('power', of_powered, [2, -3, 1], .false., &
      &    'power that a driver or coupler puts in, or that a load gives to the bodies, from its energy or not'), &
      & quantity_spec_type('elongation', of_spring, [1, 0, 0], .false., &
      &    'length of a spring less its free length, or angle less its free angle'), &
      & quantity_spec_type('rate', of_spring, [1, -1, 0], .false., 'rate of the elongation of a spring'), &
      & quantity_spec_type('axial_force', of_section, [1, -2, 1], .false., &
      &    'tension in a beam or member just before a point, at its start just behind'), &
      & quantity_spec_type('shear_force', of_section, [1, -2, 1], .false., &
      &    'force to the left that the part behind the section exerts on the part before it'), &
      & quantity_spec_type('bending_moment', of_section, [2, -2, 1], .false., &
      &    'bending moment, that of the damping in it as in stresses; positive if the beam bends to the left'), &
      & quantity_spec_type('stress_top', of_section, [-1, -2, 1], .false., &
      &    'axial stress in the extreme fibre to the left of the axis'), &
      & quantity_spec_type('stress_bottom', of_section, [-1, -2, 1], .false., &
      &    'axial stress in the extreme fibre to the right of the axis'), &
      & quantity_spec_type('momentum_x', of_system, [1, -1, 1], .false., &
      &    'momentum of all bodies along x: momentum_x(system)'), &
      & quantity_spec_type('momentum_y', of_system, [1, -1, 1], .false., &
      &    'momentum of all bodies along y: momentum_y(system)'), &
      & quantity_spec_type('angular_momentum', of_system, [2, -1, 1], .false., &
      &    'angular momentum of all bodies about the fixed origin: angular_momentum(system)'), &
      & quantity_spec_type('coupling', of_coupler, [2, -2, 1], .false., &
      &    'what a coupler exerts: times the coefficient of a term it is the torque or force on that coordinate'), &
      & quantity_spec_type('output', of_control, [0, 0, 0], .false., &
      &    'output of a control, in the unit that its gains make of its inputs'), &
      & quantity_spec_type('state', of_state, [0, 0, 0], .false., &
      &    'state of a control, in that unit times a power of the time: state(name.x1), state(name.x2), ...'), &
      & quantity_spec_type('closed', of_contact, [0, 0, 0], .false., '1 while a rigid stop rests at a limit, else 0'), &
      & quantity_spec_type('lost', of_contact, [2, -2, 1], .false., 'energy that impacts of a rigid stop have lost in this motion')]

   !> Flexible bodies, and their frames
   character(100), parameter :: frames(2, 7) = reshape([character(100) :: &
      & '`*BEAM`, exact (the default)', 'the section at `ORIGIN`, at the start if not given: there `u1`, `u2`, `rotation` are 0', &
      & '`*BEAM` in `SEGMENTS`', 'the section at its start if that is clamped, else the line through its ends', &
      & '`*BEAM`, `K_G` or `LINEAR`, `SUPPORT=CLAMPED-...`', 'the section at its start', &
      & 'the same, `SUPPORT=PINNED-...` (the default)', 'the line through its ends, from the start', &
      & 'the same, `SUPPORT=FREE-FREE`', 'the mean motion of all of the beam: its vibrations have no momentum in it', &
      & '`*FRAME`', 'where `*BOUNDARY` holds its nodes; without it the mean motion of all of the frame', &
      & '`*FRAME, LARGE=YES`', 'the section at the start of member 1'], [2, 7])

   !> Text on the axes of points
   character(*), parameter :: of_points = 'Sections of points, from which angles of joints and TURN= count, have the axes of'// &
      & ' that frame in the'//newline//'undeformed body: in a beam with CURVATURE they are not along its tangent, but at ORIGIN.'

contains

   !> Whether a quantity is a section force or stress of a beam. `kind`: index in the table.
   elemental logical function is_internal_force(kind)
      integer, intent(in) :: kind
      is_internal_force = .false.
      if (kind > 0) is_internal_force = quantities(kind)%of == of_section
   end function is_internal_force

   !> Quantities that are computed together with this one: the other component of a force, the forces of a moment. They give the
   !> level of round-off of a quantity that is zero.
   pure function partners_of(kind) result(kinds)
      integer, intent(in) :: kind
      integer, allocatable :: kinds(:)
      select case (kind)
      case (quantity_force_x); kinds = [quantity_force_y]
      case (quantity_force_y); kinds = [quantity_force_x]
      case (quantity_force_1); kinds = [quantity_force_2]
      case (quantity_force_2); kinds = [quantity_force_1]
      case (quantity_moment); kinds = [quantity_force_x, quantity_force_y]
      case (quantity_axial_force); kinds = [quantity_shear_force]
      case (quantity_shear_force); kinds = [quantity_axial_force]
      case (quantity_bending_moment); kinds = [quantity_axial_force, quantity_shear_force]
      case (quantity_stress_top); kinds = [quantity_stress_bottom]
      case (quantity_stress_bottom); kinds = [quantity_stress_top]
      case (quantity_momentum_x); kinds = [quantity_momentum_y]
      case (quantity_momentum_y); kinds = [quantity_momentum_x]
      case (quantity_angular_momentum); kinds = [quantity_momentum_x, quantity_momentum_y]
      case (quantity_kinetic); kinds = [quantity_potential]
      case (quantity_potential); kinds = [quantity_kinetic]
      case default; allocate (kinds(0))
      end select
   end function partners_of

   !> Lines for `limber help OUTPUT`.
   function quantity_help() result(text)
      character(:), allocatable :: text
      integer :: i
      text = 'Quantities:'//newline
      do i = 1, size(quantities)
         text = text//'  '//quantities(i)%name//' of a '//argument(quantities(i)%of)//'  '// &
            & trim(quantities(i)%meaning)//newline
      end do
      text = text//newline//'u1, u2, rotation, angle, spin of a flexible body are measured from its frame, and force_1, force_2'// &
         & ' are along that; deflection'//newline//'is measured from the line through both ends. The frame is'//newline
      do i = 1, size(frames, 2)
         text = text//'  '//plain(frames(1, i))//'  '//trim(plain(frames(2, i)))//newline
      end do
      text = text//of_points//newline

   contains

      !> Text without the marks of Markdown.
      pure function plain(marked)
         character(*), intent(in) :: marked
         character(len(marked)) :: plain
         integer :: k, n
         plain = ''
         n = 0
         do k = 1, len(marked)
            if (marked(k:k) == '`') cycle
            n = n + 1
            plain(n:n) = marked(k:k)
         end do
      end function plain

   end function quantity_help

   !> The table and the frames in Markdown, for the manual.
   function quantity_manual() result(text)
      character(:), allocatable :: text
      integer :: i
      text = '| quantity | asked of | meaning |'//newline//'|---|---|---|'//newline
      do i = 1, size(quantities)
         text = text//'| `'//trim(quantities(i)%name)//'` | '//trim(argument(quantities(i)%of))//' | '// &
            & trim(quantities(i)%meaning)//' |'//newline
      end do
      text = text//newline//'## Frames of flexible bodies'//newline//newline// &
         & 'From these `u1`, `u2`, `rotation`, `angle` and `spin` are measured, and along them `force_1`, `force_2`. The same'// &
         & ' beam has'//newline//'other values of them in another model; those of `deflection(point)`, `x` and `y` are the same'// &
         & ' in all.'//newline//newline//'| body | its frame is |'//newline//'|---|---|'//newline
      do i = 1, size(frames, 2)
         text = text//'| '//trim(frames(1, i))//' | '//trim(frames(2, i))//' |'//newline
      end do
      text = text//newline//of_points//' The results say it in the attribute'//newline//'`measured_from` of a channel.'//newline
   end function quantity_manual

   !> Kind of object as text.
   pure function argument(of) result(name)
      integer, intent(in) :: of
      character(24) :: name
      character(24), parameter :: names(18) = [character(24) :: 'point', 'body', 'point of a beam', 'beam', 'joint', &
         & 'driver', 'system', 'spring', 'spring', 'driver, spring', 'joint, bushing', 'driver, coupler, load', &
         & 'point of a beam or frame', 'point of a beam or frame', 'coupler', 'control', 'state of a control', &
         & 'rigid stop']
      name = names(of)
   end function argument

end module limber_model_quantities
