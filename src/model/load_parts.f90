!> Parts of loads: new ones, and what all loads read from a block. Each load consists of parts, and each part acts along one scalar
!> function of the motion. Floor: model. Source: doc/theory, eqs. (3.31)-(3.36).
module limber_model_load_parts
   use limber_base_kinds, only: wp
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: op_constant
   use limber_deck_origin, only: origin_type
   use limber_model_model, only: model_type, load_part_type, named_load_type, body_point, ground
   use limber_model_points, only: add_point, find_point
   implicit none
   private
   public :: new_part, set_law, constant, is_zero, append_part, name_load, describe_load
   public :: find_pair, check_turning, need_frame, section, frame_point, turn_alike, keep_distance

contains

   !> A part without stiffness, damping and law. `along`: kind of coordinate; `first`, `second`: points, or 0.
   pure function new_part(along, first, second) result(part)
      integer, intent(in) :: along, first, second
      type(load_part_type) :: part
      part%along = along
      part%points = [first, second]
   end function new_part

   !> Whether a law is the constant zero.
   pure logical function is_zero(law)
      type(expression_type), intent(in) :: law
      is_zero = .false.
      if (law%is_constant()) is_zero = .not. abs(law%constant_value()) > 0.0_wp
   end function is_zero

   !> Gives a part a law and its factor.
   pure subroutine set_law(part, law, factor)
      type(load_part_type), intent(inout) :: part
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: factor
      part%driven = .true.
      part%law = law
      part%factor = factor
   end subroutine set_law

   !> A constant law.
   pure function constant(value) result(law)
      real(wp), intent(in) :: value
      type(expression_type) :: law
      allocate (law%codes(1), source=op_constant)
      allocate (law%operands(1), source=1)
      allocate (law%constants(1), source=value)
      allocate (law%slots(0))
   end function constant

   !> Appends a part to the model. No array constructor: gfortran copies types with deep components badly there.
   subroutine append_part(model, part)
      type(model_type), intent(inout) :: model
      type(load_part_type), intent(in) :: part
      type(load_part_type), allocatable :: longer(:)
      integer :: n
      n = size(model%load_parts) + 1
      allocate (longer(n))
      longer(:n - 1) = model%load_parts
      longer(n) = part
      call move_alloc(longer, model%load_parts)
   end subroutine append_part

   !> Enters a named load with the parts from `first` to the last one.
   subroutine name_load(model, name, first)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: first
      type(named_load_type), allocatable :: longer(:)
      integer :: n
      n = size(model%loads) + 1
      allocate (longer(n))
      longer(:n - 1) = model%loads
      longer(n)%name = name
      longer(n)%first = first
      longer(n)%last = size(model%load_parts)
      longer(n)%symbol = ''
      call move_alloc(longer, model%loads)
   end subroutine name_load

   !> Sets what *OUTPUT and drawings can ask of the last load; the default is nothing.
   pure subroutine describe_load(model, stretches, angular, holds_sections, symbol, from_second)
      type(model_type), intent(inout) :: model
      !> As in `named_load_type`
      logical, intent(in), optional :: stretches, angular, holds_sections, from_second
      character(*), intent(in), optional :: symbol
      associate (load => model%loads(size(model%loads)))
         if (present(stretches)) load%stretches = stretches
         if (present(angular)) load%angular = angular
         if (present(holds_sections)) load%holds_sections = holds_sections
         if (present(symbol)) load%symbol = symbol
         if (present(from_second)) load%from_second = from_second
      end associate
   end subroutine describe_load

   !> Finds the two points of the data line; 0 and an error where there is none.
   subroutine find_pair(block, model, points, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      integer, intent(out) :: points(2)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, 2
         points(i) = find_point(model, block%lines(1)%text(i), block%lines(1)%origin_of(i), diagnostics)
      end do
   end subroutine find_pair

   !> Reports points of a rotational spring on a point mass.
   subroutine check_turning(block, model, points, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      integer, intent(in) :: points(2)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, 2
         call need_frame(model, points(i), block%lines(1)%text(i), block%lines(1)%origin_of(i), diagnostics)
      end do
   end subroutine check_turning

   !> Reports a point on a point mass, which has no rotation.
   subroutine need_frame(model, point, text, origin, diagnostics)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      character(*), intent(in) :: text
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      if (model%points(point)%body == ground) return
      if (model%bodies(model%points(point)%body)%kind == body_point) call diagnostics%add(origin, &
         & "'"//text//"' is a point mass and does not turn")
   end subroutine need_frame

   !> Point of an option whose section is meant; 0 with an error if there is none.
   integer function section(block, option, model, diagnostics) result(point)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: option
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      point = find_point(model, block%text(option), block%origin_of(option), diagnostics)
      if (point > 0) call need_frame(model, point, block%text(option), block%origin_of(option), diagnostics)
   end function section

   !> Adds a point that turns with the frame of a body, independent of deflections.
   integer function frame_point(model, body) result(point)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: body
      real(wp), allocatable :: phi(:, :), psi(:)
      allocate (phi(2, model%bodies(body)%reduced%n), psi(model%bodies(body)%reduced%n))
      phi = 0.0_wp
      psi = 0.0_wp
      call add_point(model, ' '//model%bodies(body)%name, body, [0.0_wp, 0.0_wp], phi, psi)
      point = model%counts%points
   end function frame_point

   !> Whether two sections always turn alike: those of a rigid body, or one section of a beam.
   pure logical function turn_alike(model, points)
      type(model_type), intent(in) :: model
      integer, intent(in) :: points(2)
      associate (first => model%points(points(1)), second => model%points(points(2)))
         turn_alike = first%body == second%body
         if (turn_alike) turn_alike = all(abs(first%psi - second%psi) <= 0.0_wp)
      end associate
   end function turn_alike

   !> Whether two points always have the same distance: those of a rigid body, or one point of a beam.
   pure logical function keep_distance(model, points)
      type(model_type), intent(in) :: model
      integer, intent(in) :: points(2)
      associate (first => model%points(points(1)), second => model%points(points(2)))
         keep_distance = first%body == second%body
         if (.not. keep_distance .or. size(first%psi) == 0) return
         keep_distance = all(abs(first%p0 - second%p0) <= 0.0_wp) .and. all(abs(first%phi - second%phi) <= 0.0_wp)
         if (keep_distance .and. first%exact .and. second%exact) keep_distance = all(abs(first%reach - second%reach) <= 0.0_wp)
      end associate
   end function keep_distance

end module limber_model_load_parts
