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
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: soften_constraints

   !> e relative to the mobility of a body of mean mass: well above round-off, well below one
   real(wp), parameter :: softness = 1.0e-8_wp

contains

   !> Makes a system ready for redundant constraints. A workspace is to be made anew after it.
   subroutine soften_constraints(system)
      type(system_type), intent(inout) :: system
      integer :: i, k
      real(wp) :: mass
      integer :: count
      associate (tree => system%tree)
         tree%joint = 0
         tree%driver = 0
         tree%side = 0
         tree%carrier = 0
         tree%marker = 0
         tree%grip = 0
         tree%holders = 0
         tree%holds = .false.
         tree%axes = 0
         tree%axis_rows = 0
         tree%given = .false.
         tree%timed = [integer ::]
         tree%first = 0
         tree%next = 0
         tree%body = 0
         tree%open = [(i, i=1, size(system%constraints))]
         tree%plain = .true.
         tree%columns = 0
         tree%free = 0
         do i = 1, size(tree%count)
            tree%order(i) = i
            tree%count(i) = system%layout%rates(i)
            do k = 1, tree%count(i)
               tree%free = tree%free + 1
               tree%columns(k, i) = tree%free
            end do
         end do
         do i = 1, system%nc
            tree%row(i) = tree%free + i
         end do
         tree%equations = [(i, i=1, system%nc)]
         tree%unknowns = tree%free + system%nc
      end associate
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

end module limber_multibody_compliant_constraints
