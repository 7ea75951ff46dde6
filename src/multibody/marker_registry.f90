!> Register of markers, directions and followed angles, each once. Markers, directions, followed angles, deflections; and where
!> these are in the first guess. Floor: multibody. Source: doc/theory, eqs. (3.7), (3.9), (3.14).
module limber_multibody_marker_registry
   use limber_base_kinds, only: wp
   use limber_deck_operations, only: jet_type
   use limber_model_driver_laws, only: driven_motion
   use limber_model_lists, only: append
   use limber_model_model, only: model_type, driver_type, point_type, driver_angle, ground
   use limber_model_switches, only: first_states, acts
   use limber_multibody_plane_vectors, only: along
   use limber_multibody_kinematics, only: angle_type
   use limber_multibody_layout, only: layout_type, new_layout
   implicit none
   private
   public :: registry_type, start_registry, end_registry, marker_of, frame_marker, frame_point, direction_of, frame_direction
   public :: angle_of, bend_of
   public :: guessed_angle, guessed_turn, guessed_position

   !> The model with its layout, and what is asked for
   type :: registry_type
      type(model_type) :: model
      type(layout_type) :: layout
      !> Points of the markers that joints and loads use; like the points of the model longer than needed until all is there
      integer, allocatable :: marker_points(:)
      !> Number of markers; marker of each point, 0: none
      integer :: markers = 0
      integer, allocatable :: point_marker(:)
      !> Angles that they use, with their values in the first guess
      type(angle_type), allocatable :: angles(:)
      !> Bodies whose deflections they use
      integer, allocatable :: bends(:)
   end type registry_type

contains

   !> Nothing is asked for yet.
   subroutine start_registry(system, model)
      class(registry_type), intent(inout) :: system
      type(model_type), intent(in) :: model
      system%model = model
      system%model%counts%points = size(model%points)
      system%layout = new_layout(model)
      allocate (system%point_marker(size(model%points)), source=0)
      allocate (system%marker_points(0), system%angles(0), system%bends(0))
   end subroutine start_registry

   !> Cuts the lists to what is in them, when all is there.
   subroutine end_registry(system)
      class(registry_type), intent(inout) :: system
      system%marker_points = system%marker_points(:system%markers)
      associate (model => system%model)
         if (size(model%points) > model%counts%points) model%points = model%points(:model%counts%points)
      end associate
   end subroutine end_registry

   !> Index of the marker at a point; a new one if there is none yet.
   integer function marker_of(system, point) result(marker)
      class(registry_type), intent(inout) :: system
      integer, intent(in) :: point
      if (point > size(system%point_marker)) call lengthen(system%point_marker, point)
      marker = system%point_marker(point)
      if (marker > 0) return
      system%markers = system%markers + 1
      marker = system%markers
      if (marker > size(system%marker_points)) call lengthen(system%marker_points, marker)
      system%marker_points(marker) = point
      system%point_marker(point) = marker
   end function marker_of

   !> Makes a list longer than it has to be; zeros follow.
   pure subroutine lengthen(list, least)
      integer, allocatable, intent(inout) :: list(:)
      integer, intent(in) :: least
      integer, allocatable :: longer(:)
      allocate (longer(max(least, 2*size(list))), source=0)
      longer(:size(list)) = list
      call move_alloc(longer, list)
   end subroutine lengthen

   !> Index of the marker that is the direction at an angle in the section at a point; a new one if there is none yet. A point
   !> mass does not turn: its directions are those of the ground.
   integer function direction_of(system, point, angle) result(marker)
      class(registry_type), intent(inout) :: system
      integer, intent(in) :: point
      !> From the first axis of the frame, in the undeformed body [rad]
      real(wp), intent(in) :: angle
      type(point_type) :: wanted
      real(wp) :: own
      associate (section => system%model%points(point))
         own = angle - section%lean
         wanted%name = section%name
         wanted%direction = .true.
         wanted%exact = section%exact
         if (section%body /= ground) then
            if (system%layout%framed(section%body)) wanted%body = section%body
         end if
         wanted%p0 = [cos(own), sin(own)]
         allocate (wanted%psi(size(section%psi)), source=section%psi)
         allocate (wanted%phi(2, size(section%psi)))
         wanted%phi(1, :) = -sin(own)*section%psi
         wanted%phi(2, :) = cos(own)*section%psi
      end associate
      marker = marker_of(system, index_of(system, wanted))
   end function direction_of

   !> Index of the marker that is the direction at an angle in the frame of a body, whatever its deflection.
   integer function frame_direction(system, body, angle) result(marker)
      class(registry_type), intent(inout) :: system
      !> Index of the body, or `ground`
      integer, intent(in) :: body
      !> [rad]
      real(wp), intent(in) :: angle
      type(point_type) :: wanted
      wanted = bare_point(system, body)
      wanted%direction = .true.
      wanted%p0 = [cos(angle), sin(angle)]
      marker = marker_of(system, index_of(system, wanted))
   end function frame_direction

   !> Index of the marker at the origin of a body's frame, whatever its deflection.
   integer function frame_marker(system, body) result(marker)
      class(registry_type), intent(inout) :: system
      !> Index of the body
      integer, intent(in) :: body
      marker = marker_of(system, index_of(system, bare_point(system, body)))
   end function frame_marker

   !> Index of the point at the origin of a body's frame that does not move in it.
   integer function frame_point(system, body) result(index)
      class(registry_type), intent(inout) :: system
      integer, intent(in) :: body
      index = index_of(system, bare_point(system, body))
   end function frame_point

   !> The origin of a body's frame.
   function bare_point(system, body) result(point)
      class(registry_type), intent(in) :: system
      integer, intent(in) :: body
      type(point_type) :: point
      integer :: n
      n = 0
      if (body /= ground) n = system%layout%n(body)
      point%name = ''
      point%body = body
      allocate (point%phi(2, n), point%psi(n))
      point%phi = 0.0_wp
      point%psi = 0.0_wp
   end function bare_point

   !> Index of the deflections of a body; new ones if nobody has asked for them.
   integer function bend_of(system, body) result(bend)
      class(registry_type), intent(inout) :: system
      integer, intent(in) :: body
      do bend = 1, size(system%bends)
         if (system%bends(bend) == body) return
      end do
      system%bends = [system%bends, body]
   end function bend_of

   !> Index of a point that the deck does not name; a new one if there is none like it.
   integer function index_of(system, wanted) result(index)
      class(registry_type), intent(inout) :: system
      type(point_type), intent(in) :: wanted
      do index = system%model%counts%points, 1, -1
         if (is_same(system%model%points(index), wanted)) return
      end do
      call append(system%model%points, system%model%counts%points, wanted)
      index = system%model%counts%points
   end function index_of

   !> Whether two are one point, or one direction.
   pure logical function is_same(a, b)
      type(point_type), intent(in) :: a, b
      is_same = (a%direction .eqv. b%direction) .and. a%body == b%body .and. size(a%psi) == size(b%psi)
      if (is_same) is_same = .not. (any(abs(a%p0 - b%p0) > 0.0_wp) .or. any(abs(a%psi - b%psi) > 0.0_wp) &
         & .or. any(abs(a%phi - b%phi) > 0.0_wp))
      if (is_same) is_same = allocated(a%reach) .eqv. allocated(b%reach)
      if (is_same .and. allocated(a%reach)) is_same = .not. any(abs(a%reach - b%reach) > 0.0_wp)
   end function is_same

   !> Index of the followed angle of the vector from one marker to another, or of a direction (first marker 0).
   integer function angle_of(system, first, second) result(angle)
      class(registry_type), intent(inout) :: system
      integer, intent(in) :: first, second
      type(angle_type), allocatable :: longer(:)
      do angle = 1, size(system%angles)
         if (all(system%angles(angle)%markers == [first, second])) return
      end do
      allocate (longer(angle))
      longer(:angle - 1) = system%angles
      longer(angle)%markers = [first, second]
      longer(angle)%value = guessed_angle(system, first, second)
      call move_alloc(longer, system%angles)
   end function angle_of

   !> The angle of a vector in the first guess of the model; that of a direction with the turns that the deck gives its body.
   real(wp) function guessed_angle(system, first, second) result(angle)
      class(registry_type), intent(in) :: system
      integer, intent(in) :: first, second
      real(wp) :: vector(2)
      associate (to => system%model%points(system%marker_points(second)))
         if (first > 0) then
            vector = guessed_position(system, to) - guessed_position(system, system%model%points(system%marker_points(first)))
            angle = atan2(vector(2), vector(1))
         else
            angle = atan2(to%p0(2), to%p0(1))
            if (to%body /= ground) angle = angle + guessed_turn(system, to%body)
         end if
      end associate
   end function guessed_angle

   !> Angle of a body's frame in the first guess: as it is driven, or as the deck says.
   real(wp) function guessed_turn(system, body) result(angle)
      class(registry_type), intent(in) :: system
      integer, intent(in) :: body
      integer :: i
      angle = system%model%bodies(body)%angle
      do i = 1, size(system%model%drivers)
         associate (driver => system%model%drivers(i))
            if (driver%kind == driver_angle .and. driver%body == body .and. acts(driver%switch, first_states(system%model))) &
               & angle = driven_at(driver, system%model%dynamics%start)
         end associate
      end do
   end function guessed_turn

   !> What a driver prescribes at a time.
   pure real(wp) function driven_at(driver, t) result(value)
      type(driver_type), intent(in) :: driver
      real(wp), intent(in) :: t
      type(jet_type) :: jet
      jet = driven_motion(driver, t)
      value = jet%value
   end function driven_at

   !> Place of a point in the first guess of the model, undeformed (2).
   function guessed_position(system, point) result(position)
      class(registry_type), intent(in) :: system
      type(point_type), intent(in) :: point
      real(wp) :: position(2), angle
      position = point%p0
      if (point%body == ground) return
      position = system%model%bodies(point%body)%position
      if (.not. system%layout%framed(point%body)) return
      angle = guessed_turn(system, point%body)
      position = position + along(point%p0, [cos(angle), sin(angle)])
   end function guessed_position

end module limber_multibody_marker_registry
