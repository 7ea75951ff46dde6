!> Motions without inertia that nothing holds. Bodies without mass or moment of inertia have them, if their joints leave them free.
!> They have no accelerations, whatever forces act on them. Floor: multibody. Source: doc/theory, eq. (4.3).
module limber_multibody_massless
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dgesvd
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix, fill, full_matrix, small_scene
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: find_massless

contains

   !> Names the body whose free motion has no inertia.
   subroutine find_massless(system, work, t, q, body, turns)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; assembled coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      !> Its index; 0 if there is none, or too many without mass to look at
      integer, intent(out) :: body
      !> Whether that motion is a rotation
      logical, intent(out) :: turns
      real(wp), parameter :: nothing = 1.0e-9_wp
      type(constraint_matrix_type) :: matrix
      real(wp), allocatable :: motions(:, :), rates(:, :), values(:), vectors(:, :), buffer(:), none(:, :)
      integer, allocatable :: owner(:)
      logical, allocatable :: turning(:)
      integer :: k, m, n, info
      body = 0
      turns = .false.
      n = count_massless(system)
      if (n == 0 .or. n > 3*small_scene .or. system%nc > 10*small_scene) return
      allocate (owner(n), turning(n))
      if (system%nc == 0) then
         call list_massless(system, q, [integer ::], [real(wp) ::], motions, owner, turning)
         body = owner(1)
         turns = turning(1)
         return
      end if
      call new_constraint_matrix(system, .true., matrix, .true.)
      call place_constraints(system, work, t, q)
      call fill(system, work, matrix)
      allocate (motions(matrix%columns, n))
      call list_massless(system, q, matrix%rate(:matrix%columns), matrix%scale(:matrix%columns), motions, owner, turning)
      allocate (rates(system%nc + n, n), source=0.0_wp)
      rates(:system%nc, :) = matmul(full_matrix(matrix), motions)
      m = size(rates, 1)
      allocate (values(n), vectors(n, n), buffer(20*(m + n) + 100), none(1, 1))
      call dgesvd('N', 'A', m, n, rates, m, values, none, 1, vectors, n, buffer, size(buffer), info)
      if (info /= 0) return
      if (values(n) > nothing*max(1.0_wp, values(1))) return
      k = maxloc(abs(vectors(n, :)), dim=1)
      body = owner(k)
      turns = turning(k)
   end subroutine find_massless

   !> Number of the motions of single bodies that have no inertia.
   pure integer function count_massless(system) result(count)
      type(system_type), intent(in) :: system
      integer :: i
      count = 0
      do i = 1, size(system%layout%q)
         if (.not. system%inertia(1, i) > 0.0_wp) count = count + 2
         if (system%layout%framed(i) .and. no_inertia(system%inertia(:, i))) count = count + 1
      end do
   end function count_massless

   !> Whether a body has no moment of inertia about its centre of mass.
   pure logical function no_inertia(inertia)
      !> Mass, its moments, moment of inertia about the origin (4)
      real(wp), intent(in) :: inertia(4)
      no_inertia = .not. inertia(1)*inertia(4) - inertia(2)**2 - inertia(3)**2 > 1.0e-14_wp*inertia(1)*inertia(4)
      if (.not. inertia(1) > 0.0_wp) no_inertia = .not. inertia(4) > 0.0_wp
   end function no_inertia

   !> These motions in the scaled columns of the constraint matrix, of norm one; the body of each, and whether it turns.
   subroutine list_massless(system, q, rate, scale, motions, owner, turning)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:)
      !> Rate of each column, and its scale (columns)
      integer, intent(in) :: rate(:)
      real(wp), intent(in) :: scale(:)
      !> (columns, motions)
      real(wp), allocatable, intent(inout) :: motions(:, :)
      integer, intent(out) :: owner(:)
      logical, intent(out) :: turning(:)
      real(wp) :: motion(system%layout%nw), arm(2)
      integer :: i, j, k, first, at
      k = 0
      do i = 1, size(system%layout%q)
         first = system%layout%w(i)
         at = system%layout%q(i) + 2
         if (.not. system%inertia(1, i) > 0.0_wp) then
            do j = 0, 1
               motion = 0.0_wp
               motion(first + j) = 1.0_wp
               call put(.false.)
            end do
         end if
         if (.not. (system%layout%framed(i) .and. no_inertia(system%inertia(:, i)))) cycle
         arm = 0.0_wp
         if (system%inertia(1, i) > 0.0_wp) arm = system%inertia(2:3, i)/system%inertia(1, i)
         associate (u => q(at:at + 1))
            motion = 0.0_wp
            motion(first) = u(2)*arm(1) + u(1)*arm(2)
            motion(first + 1) = -u(1)*arm(1) + u(2)*arm(2)
            motion(first + 2) = 1.0_wp
         end associate
         call put(.true.)
      end do

   contains

      subroutine put(turn)
         logical, intent(in) :: turn
         k = k + 1
         owner(k) = i
         turning(k) = turn
         if (size(rate) == 0) return
         motions(:, k) = motion(rate)/scale
         motions(:, k) = motions(:, k)/max(tiny(1.0_wp), norm2(motions(:, k)))
      end subroutine put

   end subroutine list_massless

end module limber_multibody_massless
