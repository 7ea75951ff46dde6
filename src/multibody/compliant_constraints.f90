!> Redundant constraints with a small compliance. Every constraint keeps its multiplier, none is solved in closed form, and each
!> equation may give way by a little,
!>
!>    [ M   G^T ] [ a      ]   [ Q     ]
!>    [ G   -e  ] [ lambda ] = [ gamma ]
!>
!> so that the multipliers are those of least norm; refined, the accelerations keep the equations to round-off.
!> Floor: multibody. Source: doc/theory, eqs. (4.33), (4.34).
module limber_multibody_compliant_constraints
   use limber_base_kinds, only: wp
   use limber_multibody_sparse_matrix, only: sparse_type
   use limber_multibody_system, only: system_type
   use limber_multibody_topology, only: new_tree
   implicit none
   private
   public :: soften_constraints, refine, next_correction

   !> Corrections of a solution
   integer, parameter, public :: rounds = 2
   !> e relative to the mobility of a body of mean mass: well above round-off, well below one
   real(wp), parameter :: softness = 1.0e-8_wp

contains

   !> Makes a system ready for redundant constraints. A workspace is to be made anew after it.
   subroutine soften_constraints(system)
      type(system_type), intent(inout) :: system
      integer :: i, count
      real(wp) :: mass
      system%tree = new_tree(system, system%constraints, system%nc, .false.)
      mass = 0.0_wp
      count = 0
      do i = 1, size(system%model%bodies)
         if (.not. system%model%bodies(i)%reduced%mass > 0.0_wp) cycle
         mass = mass + system%model%bodies(i)%reduced%mass
         count = count + 1
      end do
      if (count == 0) mass = 1.0_wp
      mass = mass/max(1, count)
      system%redundant = .true.
      if (allocated(system%slack)) deallocate (system%slack)
      allocate (system%slack(system%nc))
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            system%slack(item%first:item%first + item%rows - 1) = softness*(item%scale/system%model%length)**2/mass
         end associate
      end do
   end subroutine soften_constraints

   !> Takes out of a solution what constraints have given way, eq. (4.34). Leaves the last correction.
   subroutine refine(matrix, free, slack, solution, correction)
      !> With its factors
      type(sparse_type), intent(inout) :: matrix
      !> Number of unknowns before the multipliers; how much each constraint gives way (nc)
      integer, intent(in) :: free
      real(wp), intent(in) :: slack(:)
      !> (free + nc)
      real(wp), contiguous, intent(inout) :: solution(:), correction(:)
      integer :: round
      correction(free + 1:) = solution(free + 1:)
      do round = 1, rounds
         call next_correction(matrix, free, slack, correction)
         solution = solution + correction
      end do
   end subroutine refine

   !> The correction behind the one before, or behind the multipliers of the solution.
   subroutine next_correction(matrix, free, slack, correction)
      type(sparse_type), intent(inout) :: matrix
      integer, intent(in) :: free
      real(wp), intent(in) :: slack(:)
      real(wp), contiguous, intent(inout) :: correction(:)
      correction(:free) = 0.0_wp
      correction(free + 1:) = -slack*correction(free + 1:)
      call matrix%solve(correction)
   end subroutine next_correction

end module limber_multibody_compliant_constraints
