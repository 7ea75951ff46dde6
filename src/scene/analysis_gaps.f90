!> Gap of time between two analyses. Drivers have gone on in it, and all that they move goes along, on its branch and with its
!> turns. Floor: scene. Source: doc/theory, eq. (3.13).
module limber_scene_analysis_gaps
   use limber_base_kinds, only: wp
   use limber_scene_scene, only: scene_type
   use limber_multibody_assembly, only: turn_rates
   use limber_multibody_assembly_newton, only: close_positions
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix
   use limber_multibody_kinematics, only: angle_type, place_frames, settle_angles
   use limber_multibody_turn_counts, only: count_turns, driven_turn
   implicit none
   private
   public :: pass_gap

   !> Largest turn of a driven frame at once [rad]; most places in a gap
   real(wp), parameter :: stride = 0.2_wp
   integer, parameter :: most = 100000

contains

   !> Carries the place of the scene from one time to another by its frames: deflections stay. Where a place in between does not
   !> exist, it stays as it was.
   subroutine pass_gap(scene, from, to)
      type(scene_type), intent(inout) :: scene
      !> Times of the place, and of where it goes
      real(wp), intent(in) :: from, to
      type(constraint_matrix_type) :: frames
      real(wp) :: t, next, step, q(size(scene%q)), before(size(scene%q)), turned(size(scene%system%layout%q))
      type(angle_type), allocatable :: angles(:)
      integer :: tries
      logical :: done
      if (.not. abs(to - from) > 0.0_wp .or. size(scene%work%kinematics%drives) == 0) return
      if (.not. driven_turn(scene%system, from, to) > stride) then
         if (.not. driven_turn(scene%system, from, 0.5_wp*(from + to)) > stride) return
      end if
      allocate (angles, source=scene%work%kinematics%angles)
      q = scene%q
      turned = 0.0_wp
      t = from
      next = to
      associate (system => scene%system, work => scene%work)
         call new_constraint_matrix(system, .false., frames)
         do tries = 1, most
            if (driven_turn(system, t, next) > stride .and. abs(next - t) > 1.0e-6_wp*abs(to - from)) then
               next = t + 0.5_wp*(next - t)
               cycle
            end if
            before = q
            call close_positions(system, work, frames, next, q, done)
            if (.not. done) exit
            call count_turns(system%layout, before, q, turned)
            call place_frames(system%model, system%layout, next, q, work%kinematics)
            call settle_angles(work%kinematics, .false.)
            if (.not. abs(to - next) > 0.0_wp) then
               call turn_rates(system, scene%q, q, scene%v)
               scene%q = q
               if (allocated(scene%angle)) scene%angle = scene%angle + turned
               return
            end if
            step = next - t
            t = next
            next = t + 2*step
            if (abs(next - from) > abs(to - from)) next = to
         end do
         work%kinematics%angles(:) = angles
      end associate
   end subroutine pass_gap

end module limber_scene_analysis_gaps
