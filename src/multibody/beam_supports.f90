!> Joints that hold a clamped beam across its axis. Those whose other side cannot give way to a force across, however soft the beam
!> is. Beside the clamp, what hangs on the beam alone, or what slides or swings across it, holds nothing, and Euler's load is that
!> of a free end. Floor: multibody. Source: doc/theory, eq. (7.14).
module limber_multibody_beam_supports
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev
   use limber_model_model, only: model_type, body_type, ground
   use limber_multibody_drivers, only: driven_angle_type
   use limber_multibody_free_motions, only: rate_scales
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: find_supports

   !> Most bodies on the other side of a joint whose motions are looked at
   integer, parameter :: most = 40
   !> Part of a length along a beam in which places are one; of a force that is none; sine of a direction along the beam
   real(wp), parameter :: near = 1.0e-6_wp, none = 1.0e-8_wp, along = 0.01_wp

contains

   !> Looks at all joints of clamped beams.
   subroutine find_supports(system, work, q)
      !> What the joints of its model bear is set
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      !> First coordinates (nq)
      real(wp), intent(in) :: q(:)
      integer :: body, i, side, clamp
      real(wp) :: normal(2), scale(system%layout%nw)
      logical :: begun, bears, guides
      begun = .false.
      do body = 1, size(system%model%bodies)
         if (.not. is_beam(system%model%bodies(body))) cycle
         call find_clamp(system, body, clamp)
         if (clamp < 0) cycle
         if (.not. begun) then
            begun = .true.
            scale = rate_scales(system)
            call place_constraints(system, work, system%model%dynamics%start, q)
         end if
         normal = [-q(system%layout%q(body) + 3), q(system%layout%q(body) + 2)]
         do i = 1, size(system%model%joints)
            do side = 1, 2
               if (system%constraints(i)%item%bodies(side) /= body .or. system%model%joints(i)%points(side) == 0) cycle
               if (clamp > 0) then
                  if (is_near(system%model, body, place_of(system, i, body), place_of(system, clamp, body))) cycle
               end if
               call judge(system, work, scale, i, side, normal, bears, guides)
               system%model%joints(i)%bears(side) = bears
               system%model%joints(i)%guides(side) = guides
            end do
         end do
      end do
   end subroutine find_supports

   !> Whether a body is a straight beam of one piece.
   pure logical function is_beam(body)
      type(body_type), intent(in) :: body
      is_beam = .not. body%is_frame .and. body%whole == 0 .and. body%beam%length > 0.0_wp .and. body%beam%ei > 0.0_wp
   end function is_beam

   !> The joint that clamps a beam: a weld to what joints connect with the ground, or else to the heaviest body; 0: a driver of its
   !> angle does; -1: none.
   pure subroutine find_clamp(system, body, clamp)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      integer, intent(out) :: clamp
      logical :: reached(0:size(system%model%bodies))
      integer :: i, other
      real(wp) :: heaviest
      clamp = -1
      heaviest = -1.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (all(item%bodies /= body)) cycle
            select type (item)
            type is (driven_angle_type)
               clamp = 0
            end select
            if (i > size(system%model%joints)) cycle
            if (.not. system%model%joints(i)%is_weld()) cycle
            other = sum(item%bodies, mask=item%bodies /= body)
            call reach(system, other, body, reached)
            if (reached(ground)) then
               clamp = i
               return
            end if
            if (clamp == 0) cycle
            if (system%model%bodies(other)%reduced%mass <= heaviest) cycle
            heaviest = system%model%bodies(other)%reduced%mass
            clamp = i
         end associate
      end do
   end subroutine find_clamp

   !> Bodies that constraints connect with a body, but by a beam, or the ground, which is told of (0 is the ground). Where they are
   !> too many they are taken to be on the ground.
   pure subroutine reach(system, body, beam, reached)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body, beam
      logical, intent(out) :: reached(0:)
      logical :: changed
      integer :: i, count
      reached = .false.
      reached(body) = .true.
      changed = body /= ground
      count = 1
      do while (changed)
         changed = .false.
         do i = 1, size(system%constraints)
            associate (ends => system%constraints(i)%item%bodies)
               if (any(ends == beam) .or. (reached(ends(1)) .eqv. reached(ends(2)))) cycle
               ! What else is on the ground is not connected by that
               if (any(ends == ground .and. reached(ends))) cycle
               reached(ends) = .true.
               changed = .true.
               count = count + 1
               if (count <= most) cycle
               reached(ground) = .true.
               return
            end associate
         end do
      end do
   end subroutine reach

   !> Whether the other side of a joint resists a force across the beam, which is held in its place, or a couple: the force of the
   !> joint is a sum of those of the constraints there, eq. (7.14).
   subroutine judge(system, work, scale, joint, side, normal, bears, guides)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: scale(:), normal(2)
      integer, intent(in) :: joint, side
      logical, intent(out) :: bears, guides
      logical :: reached(0:size(system%model%bodies))
      real(wp), allocatable :: rows(:, :), own(:, :), part(:, :)
      real(wp) :: across(6), value(6), room(64*6)
      logical :: turns(6)
      integer :: beam, other, i, k, n, count, info
      bears = .true.
      guides = .false.
      associate (item => system%constraints(joint)%item)
         beam = item%bodies(side)
         other = item%bodies(3 - side)
         n = item%rows
         if (n == 0 .or. n > size(across)) return
         do k = 1, n
            across(k) = dot_product(normal, work%jacobians(side, joint)%z(k, :2))/item%scale
            ! Rows of rotations alone
            turns(k) = .not. any(abs(work%jacobians(side, joint)%z(k, :2)) > 0.0_wp)
         end do
         allocate (own(system%layout%nw, n), source=0.0_wp)
         if (other /= ground) call put_rows(system, work, scale, joint, 3 - side, own)
      end associate
      call reach(system, other, beam, reached)
      if (count_of(reached(1:)) >= most) return
      count = 0
      do i = 1, size(system%constraints)
         if (any_within(reached, system%constraints(i)%item%bodies)) count = count + system%constraints(i)%item%rows
      end do
      allocate (rows(system%layout%nw, count), source=0.0_wp)
      count = 0
      do i = 1, size(system%constraints)
         associate (ends => system%constraints(i)%item%bodies, m => system%constraints(i)%item%rows)
            if (any(ends == beam)) then
               if (is_near(system%model, beam, place_of(system, i, beam), place_of(system, joint, beam))) cycle
            end if
            if (.not. any_within(reached, ends)) cycle
            do k = 1, 2
               if (ends(k) /= ground .and. ends(k) /= beam) call put_rows(system, work, scale, i, k, rows(:, count + 1:count + m))
            end do
            count = count + m
         end associate
      end do
      call take_out(rows(:, :count), own)
      allocate (part(n, n))
      part = matmul(transpose(own), own)
      call dsyev('V', 'L', n, part, n, value, room, size(room), info)
      if (info /= 0) return
      bears = .false.
      do k = 1, n
         if (value(k) > none) cycle
         bears = bears .or. abs(dot_product(part(:, k), across(:n))) > along*norm2(across(:n))
         guides = guides .or. norm2(pack(part(:, k), turns(:n))) > along
      end do
      guides = guides .and. .not. bears
   end subroutine judge

   !> Whether one of two bodies, not the ground, is among those reached.
   pure logical function any_within(reached, ends)
      logical, intent(in) :: reached(0:)
      integer, intent(in) :: ends(2)
      any_within = any(reached(ends) .and. ends /= ground)
   end function any_within

   pure integer function count_of(flags)
      logical, intent(in) :: flags(:)
      count_of = count(flags)
   end function count_of

   !> Rows of a constraint on the frame of one of its bodies, scaled, a column each.
   pure subroutine put_rows(system, work, scale, constraint, side, rows)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: scale(:)
      integer, intent(in) :: constraint, side
      real(wp), intent(inout) :: rows(:, :)
      integer :: first, m, k
      associate (item => system%constraints(constraint)%item)
         first = system%layout%w(item%bodies(side))
         m = system%layout%rates(item%bodies(side))
         do k = 1, item%rows
            rows(first:first + m - 1, k) = rows(first:first + m - 1, k) + work%jacobians(side, constraint)%z(k, :m) &
               & *scale(first:first + m - 1)/item%scale
         end do
      end associate
   end subroutine put_rows

   !> Takes out of vectors what is a sum of rows.
   pure subroutine take_out(rows, vectors)
      !> (nw, rows), which become orthogonal; (nw, vectors)
      real(wp), intent(inout) :: rows(:, :), vectors(:, :)
      real(wp) :: size_before
      integer :: j, k, round
      do j = 1, size(rows, 2)
         size_before = norm2(rows(:, j))
         do round = 1, 2
            do k = 1, j - 1
               rows(:, j) = rows(:, j) - dot_product(rows(:, k), rows(:, j))*rows(:, k)
            end do
         end do
         if (norm2(rows(:, j)) <= none*size_before) then
            rows(:, j) = 0.0_wp
         else
            rows(:, j) = rows(:, j)/norm2(rows(:, j))
         end if
      end do
      do j = 1, size(vectors, 2)
         size_before = max(norm2(vectors(:, j)), tiny(1.0_wp))
         do round = 1, 2
            do k = 1, size(rows, 2)
               vectors(:, j) = vectors(:, j) - dot_product(rows(:, k), vectors(:, j))*rows(:, k)
            end do
         end do
         vectors(:, j) = vectors(:, j)/size_before
      end do
   end subroutine take_out

   !> The point of a beam that a constraint is at; 0: none.
   pure integer function place_of(system, constraint, beam) result(point)
      type(system_type), intent(in) :: system
      integer, intent(in) :: constraint, beam
      point = 0
      associate (item => system%constraints(constraint)%item)
         if (item%bodies(1) == beam) point = item%points(1)
         if (item%bodies(2) == beam) point = item%points(2)
      end associate
   end function place_of

   !> Whether two points of a beam are one.
   pure logical function is_near(model, beam, first, second)
      type(model_type), intent(in) :: model
      integer, intent(in) :: beam, first, second
      is_near = first == second
      if (first == 0 .or. second == 0) return
      is_near = norm2(model%points(first)%p0 - model%points(second)%p0) <= near*model%bodies(beam)%beam%length
   end function is_near

end module limber_multibody_beam_supports
