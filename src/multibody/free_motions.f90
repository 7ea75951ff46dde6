!> Free motions: null space of the constraint Jacobian. A basis of the null space of their Jacobian, in scaled rates, and the
!> stiffness and mass of the scene on it. Dense: for analyses of one state, not for the time loop. Floor: multibody. Source:
!> doc/theory, eqs. (6.1), (6.2); Golub and Van Loan, Matrix Computations, section 5.4.
module limber_multibody_free_motions
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev, dgeev, dgeqp3, dorgqr
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix, fill, full_matrix
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: tangent_type
   use limber_multibody_tangent_products, only: times_stiffness
   implicit none
   private
   public :: free_motions_type, find_freedom, rate_scales, lowest_stiffness, has_potential, motion_text

   !> Pivot, relative to the largest, below which a constraint is taken to repeat others
   real(wp), parameter :: no_pivot = 1.0e-10_wp

   !> Motions that are left
   type :: free_motions_type
      !> Number of independent constraint equations
      integer :: rank = 0
      !> Directions in the layout of the rates (nw, number), orthonormal once divided by the scales
      real(wp), allocatable :: basis(:, :)
   end type free_motions_type

contains

   !> What a change of each rate's coordinate is compared with (nw): the scene's length, a radian, a deflection of the body's size.
   pure function rate_scales(system) result(scale)
      type(system_type), intent(in) :: system
      real(wp) :: scale(system%layout%nw)
      integer :: i, first, m
      do i = 1, size(system%layout%w)
         first = system%layout%w(i)
         m = system%layout%rates(i)
         scale(first:first + 1) = system%model%length
         if (.not. system%layout%framed(i)) cycle
         scale(first + 2) = 1.0_wp
         if (system%layout%n(i) > 0) scale(first + m:first + m + system%layout%n(i) - 1) = &
            & system%model%bodies(i)%size/system%model%bodies(i)%largest_shape
      end do
   end function rate_scales

   !> Finds the motions that are left at the Jacobians in the workspace.
   subroutine find_freedom(system, work, held, freedom, but)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> True if deflections are held: frames alone move
      logical, intent(in) :: held
      type(free_motions_type), intent(inout) :: freedom
      !> The one body that deflects all the same
      integer, intent(in), optional :: but
      type(constraint_matrix_type) :: matrix
      real(wp), allocatable :: full(:, :), rows(:, :), tau(:), scratch(:), scale(:)
      integer, allocatable :: pivot(:), columns(:)
      integer :: n, m, i, info
      allocate (scale(system%layout%nw))
      scale = rate_scales(system)
      call free_columns(system, held, columns, but)
      n = size(columns)
      m = system%nc
      allocate (rows(n, max(n, m)), tau(min(n, m)), scratch(64*(n + m + 2)), pivot(m))
      ! The Jacobian, transposed and scaled: an equation in each column
      call new_constraint_matrix(system, .true., matrix, .true.)
      call fill(system, work, matrix)
      full = full_matrix(matrix)
      rows = 0.0_wp
      do i = 1, n
         rows(i, :m) = full(:, columns(i))*(scale(columns(i))/matrix%scale(columns(i)))
      end do
      pivot = 0
      freedom%rank = 0
      call dgeqp3(n, m, rows, n, pivot, tau, scratch, size(scratch), info)
      do i = 1, min(n, m)
         if (abs(rows(i, i)) > no_pivot*abs(rows(1, 1))) freedom%rank = i
      end do
      call dorgqr(n, n, min(n, m), rows, n, tau, scratch, size(scratch), info)
      if (allocated(freedom%basis)) deallocate (freedom%basis)
      allocate (freedom%basis(system%layout%nw, n - freedom%rank))
      freedom%basis = 0.0_wp
      do i = 1, n - freedom%rank
         freedom%basis(columns, i) = rows(:n, freedom%rank + i)*scale(columns)
      end do
   end subroutine find_freedom

   !> The rates that can change.
   subroutine free_columns(system, held, columns, but)
      type(system_type), intent(in) :: system
      logical, intent(in) :: held
      integer, allocatable, intent(out) :: columns(:)
      !> The one body that deflects all the same
      integer, intent(in), optional :: but
      logical :: moves(system%layout%nw)
      integer :: i, first
      moves = .true.
      do i = 1, size(system%layout%w)
         if (present(but)) then
            if (i == but) cycle
         end if
         first = system%layout%w(i) + system%layout%rates(i)
         if (held) moves(first:first + system%layout%n(i) - 1) = .false.
      end do
      allocate (columns(count(moves)))
      columns = pack([(i, i=1, size(moves))], moves)
   end subroutine free_columns

   !> The stiffness of the scene on the motions that are left, (number, number).
   subroutine free_stiffness(system, tangent, freedom, stiffness)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      type(free_motions_type), intent(in) :: freedom
      real(wp), allocatable, intent(out) :: stiffness(:, :)
      real(wp), allocatable :: product(:)
      integer :: j
      allocate (stiffness(size(freedom%basis, 2), size(freedom%basis, 2)), product(size(freedom%basis, 1)))
      do j = 1, size(stiffness, 2)
         product = 0.0_wp
         call times_stiffness(system, tangent, 1.0_wp, freedom%basis(:, j), product)
         stiffness(:, j) = matmul(product, freedom%basis)
      end do
   end subroutine free_stiffness

   !> The lowest eigenvalue of the stiffness on the motions that are left [energy], with its motion: below zero, equilibrium is
   !> unstable; zero, it is neutral.
   subroutine lowest_stiffness(system, tangent, freedom, lowest, largest, motion)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      type(free_motions_type), intent(in) :: freedom
      !> The eigenvalue of least real part, that part; and the largest of all. Without freedom: huge, zero
      real(wp), intent(out) :: lowest, largest
      !> In the layout of the rates (nw), scaled to unit length; its largest entry is positive
      real(wp), intent(out) :: motion(:)
      real(wp), allocatable :: stiffness(:, :), value(:), other(:), left(:, :), right(:, :), scratch(:), scale(:)
      integer :: n, info, least, largest_at
      lowest = huge(lowest)
      largest = 0.0_wp
      motion = 0.0_wp
      n = size(freedom%basis, 2)
      if (n == 0) return
      call free_stiffness(system, tangent, freedom, stiffness)
      allocate (value(n), other(n), left(1, n), right(n, n), scratch(64*n + 64), scale(size(motion)))
      scale = rate_scales(system)
      if (maxval(abs(stiffness - transpose(stiffness))) <= 1.0e-12_wp*maxval(abs(stiffness))) then
         stiffness = 0.5_wp*(stiffness + transpose(stiffness))
         call dsyev('V', 'L', n, stiffness, n, value, scratch, size(scratch), info)
         right = stiffness
      else
         call dgeev('N', 'V', n, stiffness, n, value, other, left, 1, right, n, scratch, size(scratch), info)
      end if
      if (info /= 0) return
      least = minloc(value, 1)
      lowest = value(least)
      largest = maxval(abs(value))
      motion = matmul(freedom%basis, right(:, least))
      largest_at = maxloc(abs(motion/scale), 1)
      motion = motion*sign(1.0_wp, motion(largest_at))/norm2(motion/scale)
   end subroutine lowest_stiffness

   !> Whether the loads have a potential near the state: their stiffness is symmetric. Forces that follow what they push have none,
   !> and equilibrium then is lost by growing vibrations, too.
   pure logical function has_potential(tangent)
      type(tangent_type), intent(in) :: tangent
      !> Difference beside the largest entry that is round-off
      real(wp), parameter :: none = 1.0e-9_wp
      integer :: i
      has_potential = .true.
      do i = 1, size(tangent%loads)
         associate (block => tangent%loads(i)%stiffness)
            if (size(block) == 0) cycle
            if (maxval(abs(block - transpose(block))) > none*maxval(abs(block))) has_potential = .false.
         end associate
      end do
   end function has_potential

   !> What moves in a motion, for messages: "body 'crank' turns, body 'rod' moves".
   function motion_text(system, motion) result(text)
      type(system_type), intent(in) :: system
      !> In the layout of the rates (nw)
      real(wp), intent(in) :: motion(:)
      character(:), allocatable :: text
      !> Part of the largest entry that is told, and bodies that are named at most
      real(wp), parameter :: told = 0.3_wp
      integer, parameter :: most = 4
      real(wp), allocatable :: scale(:)
      character(:), allocatable :: verb
      real(wp) :: largest, turning, moving, bending
      integer :: i, first, last, count
      allocate (scale(size(motion)))
      scale = rate_scales(system)
      largest = maxval(abs(motion/scale))
      text = ''
      count = 0
      do i = 1, size(system%layout%w)
         first = system%layout%w(i)
         last = first + system%layout%rates(i) + system%layout%n(i) - 1
         moving = maxval(abs(motion(first:first + 1)/scale(first:first + 1)))
         turning = 0.0_wp
         bending = 0.0_wp
         if (system%layout%framed(i)) turning = abs(motion(first + 2)/scale(first + 2))
         if (system%layout%n(i) > 0) bending = maxval(abs(motion(first + 3:last)/scale(first + 3:last)))
         if (max(moving, turning, bending) < told*largest) cycle
         verb = 'moves'
         if (turning >= told*largest) verb = 'turns'
         if (bending > max(turning, moving)) verb = 'bends'
         count = count + 1
         if (count > most) then
            text = text//', ...'
            return
         end if
         if (text /= '') text = text//', '
         text = text//"body '"//system%model%bodies(i)%name//"' "//verb
      end do
   end function motion_text

end module limber_multibody_free_motions
