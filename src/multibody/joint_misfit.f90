!> Shape of bodies whose joints do not meet as given. A bearing out of line, a follower that is pressed on its cam. Frames alone
!> cannot close such joints; of all deflections that do, those of least strain energy are taken, and of all rates that keep them
!> closed too. Loads do not count, but for the side to which a beam bends that is pushed. Floor: multibody. Source: doc/theory, eqs.
!> (4.42), (4.43).
module limber_multibody_joint_misfit
   use limber_base_kinds, only: wp
   use limber_multibody_equilibrium, only: equilibrium_type, new_equilibrium, settle, settle_rates
   use limber_multibody_layout, only: rates_of, velocities_of
   use limber_multibody_system, only: system_type, workspace_type, new_workspace
   implicit none
   private
   public :: bend_least

contains

   !> Brings an assembled scene into the shape of least strain energy that its joints and drivers allow.
   subroutine bend_least(system, t, q, v, done)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq): in, assembled; out, those of least energy; as they were if none are found
      real(wp), intent(inout) :: q(:), v(:)
      logical, intent(out) :: done
      !> Part of the weight that tells to which side a beam bends that is longer than its span
      real(wp), parameter :: beginning = 1.0e-6_wp
      type(system_type) :: unloaded
      type(workspace_type) :: work
      type(equilibrium_type) :: balance
      real(wp) :: w(system%layout%nw), lambda(system%nc), place(size(q))
      integer :: i
      unloaded = system
      unloaded%model%gravity = beginning*unloaded%model%gravity
      deallocate (unloaded%loads)
      allocate (unloaded%loads(0))
      call new_workspace(unloaded, work)
      call new_equilibrium(unloaded, balance)
      call rates_of(system%layout, q, v, w)
      do i = 1, size(system%layout%w)
         associate (first => system%layout%w(i) + system%layout%rates(i))
            w(first:first + system%layout%n(i) - 1) = 0.0_wp
         end associate
      end do
      lambda = 0.0_wp
      place = q
      call settle(unloaded, work, balance, t, place, lambda, done)
      if (.not. done) return
      q = place
      call velocities_of(system%layout, q, w, v)
      call settle_rates(unloaded, work, balance, t, q, v, lambda, w)
      call velocities_of(system%layout, q, w, v)
   end subroutine bend_least

end module limber_multibody_joint_misfit
