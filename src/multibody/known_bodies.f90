!> Bodies of known motion: drivers and joints determine them. Which constraints hold them, and what these leave free. They are
!> solved body by body, so that neither they nor what they give are unknowns of the multiplier system. Floor: multibody. Source:
!> doc/theory, eqs. (4.9)-(4.12).
module limber_multibody_known_bodies
   use limber_base_kinds, only: wp
   use limber_model_model, only: place_on_line, ground, driver_x, driver_y, driver_displacement, driver_joint_angle
   use limber_multibody_constraint, only: constraint_item_type, jacobian_type, new_jacobian
   use limber_multibody_drivers, only: driven_angle_type, driven_origin_type
   use limber_multibody_point_joints, only: revolute_type, point_on_line_type
   use limber_multibody_function_constraints, only: linear_type
   use limber_multibody_kinematics, only: kinematics_type, new_kinematics, place_frames
   use limber_multibody_layout, only: guess_place
   use limber_multibody_marker_registry, only: registry_type
   use limber_multibody_spanning_tree, only: spanning_tree_type
   implicit none
   private
   public :: known_bodies_type, new_holding, find_grip, split_motion

   !> Part of a row that must be independent of the rows before it
   real(wp), parameter :: least = 1.0e-3_wp

   !> What could hold the bodies, judged in the first guess
   type :: known_bodies_type
      !> True if there is anything of the kind
      logical :: useful = .false.
      !> Which constraints can be solved for the motion of a body (constraints)
      logical, allocatable :: suits(:)
      !> Rows on r' and omega, the latter times the length of the scene, of either side (3, 3, 2, constraints)
      real(wp), allocatable :: rows(:, :, :, :)
   end type known_bodies_type

contains

   !> Looks through all constraints.
   subroutine new_holding(registry, constraints, holding)
      class(registry_type), intent(in) :: registry
      type(constraint_item_type), intent(in) :: constraints(:)
      type(known_bodies_type), intent(out) :: holding
      type(kinematics_type) :: kinematics
      type(jacobian_type) :: first, second
      real(wp) :: q(registry%layout%nq)
      integer :: c
      allocate (holding%suits(size(constraints)))
      do c = 1, size(constraints)
         holding%suits(c) = is_suitable(registry, constraints, c)
         if (holding%suits(c)) holding%useful = holding%useful .or. is_needed(registry, constraints, c)
      end do
      if (.not. holding%useful) return
      allocate (holding%rows(3, 3, 2, size(constraints)), source=0.0_wp)
      kinematics = new_kinematics(registry%model, registry%marker_points, registry%angles, registry%bends)
      call guess_place(registry%model, registry%layout, q)
      call place_frames(registry%model, registry%layout, registry%model%dynamics%start, q, kinematics)
      do c = 1, size(constraints)
         if (.not. holding%suits(c)) cycle
         associate (item => constraints(c)%item)
            first = new_jacobian(item%rows, coordinates(item%bodies(1)))
            second = new_jacobian(item%rows, coordinates(item%bodies(2)))
            call item%jacobian(kinematics, first, second)
            first%z(:, 3) = first%z(:, 3)/registry%model%length
            second%z(:, 3) = second%z(:, 3)/registry%model%length
            ! Where a driven frame points is settled before anything else
            select type (item)
            type is (driven_angle_type)
               first%z(1, :) = [0.0_wp, 0.0_wp, 1.0_wp]
            end select
            holding%rows(:item%rows, :, 1, c) = first%z
            holding%rows(:item%rows, :, 2, c) = second%z
         end associate
      end do

   contains

      integer function coordinates(body)
         integer, intent(in) :: body
         coordinates = 0
         if (body /= ground) coordinates = registry%layout%n(body)
      end function coordinates

   end subroutine new_holding

   !> Whether a constraint can be solved for the motion of one of its bodies: its rows on a body are those of a frame, whatever
   !> the deflection, and lose rank only where the whole scene does.
   pure logical function is_suitable(registry, constraints, c) result(suits)
      class(registry_type), intent(in) :: registry
      type(constraint_item_type), intent(in) :: constraints(:)
      integer, intent(in) :: c
      integer :: k
      suits = constraints(c)%item%part_of == 0
      if (.not. suits) return
      associate (joints => size(registry%model%joints))
         select type (item => constraints(c)%item)
         type is (revolute_type)
            do k = 1, 2
               suits = suits .and. .not. moves_in_its_frame(registry, registry%marker_points(item%markers(k)))
            end do
         type is (point_on_line_type)
            do k = 1, 2
               suits = suits .and. .not. moves_in_its_frame(registry, registry%marker_points(item%markers(k)))
            end do
         type is (driven_angle_type)
         type is (driven_origin_type)
         type is (linear_type)
            if (c <= joints) then
               associate (joint => registry%model%joints(c))
                  suits = joint%keeps_angle .or. joint%place == place_on_line
               end associate
            else
               suits = any(registry%model%drivers(c - joints)%kind == [driver_x, driver_y, driver_displacement, driver_joint_angle])
            end if
            do k = 1, item%vectors
               suits = suits .and. .not. moves_in_its_frame(registry, registry%marker_points(item%markers(k)))
            end do
         class default
            suits = .false.
         end select
      end associate
   end function is_suitable

   !> Whether the tree without holding leaves something to gain: not for hinges at the origin of a frame, and driven angles.
   pure logical function is_needed(registry, constraints, c) result(needed)
      class(registry_type), intent(in) :: registry
      type(constraint_item_type), intent(in) :: constraints(:)
      integer, intent(in) :: c
      integer :: k
      needed = .true.
      select type (item => constraints(c)%item)
      type is (driven_angle_type)
         needed = .false.
      type is (revolute_type)
         needed = any(item%bodies == ground)
         do k = 1, 2
            if (item%bodies(k) == ground) cycle
            needed = needed .and. any(abs(registry%model%points(registry%marker_points(item%markers(k)))%p0) > 0.0_wp)
         end do
      end select
   end function is_needed

   !> Whether a deflection moves a point, or turns a direction, in the frame of its body.
   pure logical function moves_in_its_frame(registry, point) result(moves)
      class(registry_type), intent(in) :: registry
      integer, intent(in) :: point
      moves = any(abs(registry%model%points(point)%phi) > 0.0_wp)
   end function moves_in_its_frame

   !> Constraints that hold a body on what is known, each of them wholly: their rows on r' are independent by themselves, or a row
   !> is on the rotation alone. So the way round a loop, which may fold, is left to the multipliers.
   pure subroutine find_grip(holding, span, constraints, known, body, rates, list, count, rows)
      type(known_bodies_type), intent(in) :: holding
      type(spanning_tree_type), intent(in) :: span
      type(constraint_item_type), intent(in) :: constraints(:)
      !> Whether the motion of a body is known, and it is rigid (0:bodies); of the ground it is
      logical, intent(in) :: known(0:)
      !> The body, and the number of its frame's rates
      integer, intent(in) :: body, rates
      !> The constraints, how many, and how many rows they have
      integer, intent(out) :: list(3), count, rows
      real(wp) :: basis(2, 2), row(3)
      integer :: number, c, s, k, shifts, tried
      logical :: turns, turned
      list = 0
      count = 0
      rows = 0
      shifts = 0
      turns = .false.
      number = span%first(body)
      do while (number > 0 .and. rows < rates)
         c = (number + 1)/2
         s = number - 2*(c - 1)
         number = span%next(number)
         if (.not. holding%suits(c)) cycle
         if (.not. known(constraints(c)%item%bodies(3 - s))) cycle
         tried = shifts
         turned = turns
         do k = 1, constraints(c)%item%rows
            row = holding%rows(k, :, s, c)
            if (norm2(row(1:2)) <= least*abs(row(3))) then
               if (turned .or. rates < 3) exit
               turned = .true.
               cycle
            end if
            if (tried == 2) exit
            row(1:2) = row(1:2)/norm2(row(1:2))
            if (tried == 1) row(1:2) = row(1:2) - dot_product(basis(:, 1), row(1:2))*basis(:, 1)
            if (norm2(row(1:2)) <= least) exit
            tried = tried + 1
            basis(:, tried) = row(1:2)/norm2(row(1:2))
         end do
         if (k <= constraints(c)%item%rows) cycle
         shifts = tried
         turns = turned
         rows = shifts + merge(1, 0, turns)
         count = count + 1
         list(count) = c
      end do
   end subroutine find_grip

   !> Solves the rows that hold a frame, Z z = g: z = inverse g + hanging zeta with independent zeta, eqs. (4.9), (4.10).
   pure subroutine split_motion(rates, rows, z, scale, inverse, hanging)
      !> Number of the frame's rates, and of rows
      integer, intent(in) :: rates, rows
      !> Rows on r' and omega (3, 3), those in use first
      real(wp), intent(in) :: z(3, 3)
      !> Length that rotations are compared with
      real(wp), intent(in) :: scale
      !> (rates, rows) and (rates, rates - rows)
      real(wp), intent(inout) :: inverse(3, 3), hanging(:, :)
      real(wp) :: basis(3, 3), upper(3, 3), unit(3), length
      integer :: j, k, found
      ! Gram and Schmidt, the rows first, then whichever axes are farthest from them
      upper = 0.0_wp
      basis = 0.0_wp
      do k = 1, rows
         basis(:, k) = z(k, :)
         basis(3, k) = basis(3, k)/scale
         if (rates == 2) basis(3, k) = 0.0_wp
         do j = 1, k - 1
            upper(j, k) = dot_product(basis(:, j), basis(:, k))
            basis(:, k) = basis(:, k) - upper(j, k)*basis(:, j)
         end do
         upper(k, k) = norm2(basis(:, k))
         basis(:, k) = basis(:, k)/upper(k, k)
      end do
      do found = rows + 1, rates
         length = 0.0_wp
         do k = 1, rates
            unit = 0.0_wp
            unit(k) = 1.0_wp
            do j = 1, found - 1
               unit = unit - basis(k, j)*basis(:, j)
            end do
            if (norm2(unit) <= length*(1.0_wp + 1.0e-3_wp)) cycle
            length = norm2(unit)
            basis(:, found) = unit/length
         end do
         hanging(:, found - rows) = basis(:rates, found)
         if (rates == 3) hanging(3, found - rows) = basis(3, found)/scale
      end do
      ! Z^T = basis upper, hence inverse = basis upper^-T
      do k = rows, 1, -1
         inverse(:, k) = basis(:, k)
         do j = k + 1, rows
            inverse(:, k) = inverse(:, k) - upper(k, j)*inverse(:, j)
         end do
         inverse(:, k) = inverse(:, k)/upper(k, k)
      end do
      inverse(3, :rows) = inverse(3, :rows)/scale
   end subroutine split_motion

end module limber_multibody_known_bodies
