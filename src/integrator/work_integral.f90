!> Work put in over a step of an implicit integrator. An integral of the power, exact enough at any time within a step, with an
!> estimate of its own error, which the step obeys as it does that of the motion. Floor: integrator. Source: doc/theory, eqs.
!> (5.28), (5.35)-(5.37).
module limber_integrator_work_integral
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_integrator_radau_method, only: c => radau_c
   implicit none
   private
   public :: work_type

   !> Largest error of a step's work, in units of the scale, where nobody asks for the work: enough for the balance of energy
   real(wp), parameter :: for_balance = 1.0e-4_wp
   !> Part of an energy of the motion below which the scale of the work does not go
   real(wp), parameter :: floor_asked = 1.0e-3_wp
   !> How often the largest work may have gone through, to and fro, before errors that add up count more; part of the work of a
   !> step that is as good as round-off
   real(wp), parameter :: few = 10.0_wp, round_off = 1.0e-2_wp
   !> An error that a shorter step leaves above this part of itself is no error of the step
   real(wp), parameter :: stubborn = 0.5_wp

   !> Work put in
   type :: work_type
      !> True if a channel asks for the work
      logical :: asked = .false.
      !> At the beginning and at the end of the last step [energy]; power at the end [energy/time]
      real(wp) :: before = 0.0_wp, done = 0.0_wp, power = 0.0_wp
      !> Power at the beginning of the last step, and the length of that; 0: there is none
      real(wp) :: power_before = 0.0_wp, length = 0.0_wp
      !> Work from the beginning of the last step to a part s of it, and of the step that is tried: sum of shape(i) s^i
      real(wp) :: shape(4) = 0.0_wp, new_shape(4) = 0.0_wp
      !> Of the work that laws do what the forces of the steps have not done: energy that the scheme feeds, or takes
      real(wp) :: missed = 0.0_wp, new_missed = 0.0_wp
      !> Integral of the size of the power, of the last step and of all; largest size of the work
      real(wp) :: passing = 0.0_wp, throughput = 0.0_wp, largest = 0.0_wp
      !> Error of the attempt before that was refused for its work; 0: none was
      real(wp) :: refused = 0.0_wp
   contains
      procedure :: begin => begin_work
      procedure :: exchange => exchange_work
      procedure :: try_stages, try_ends, try_cubic, try_known, is_within, is_rough, allowed, scale_of, note_passing, accept, within
   end type work_type

contains

   !> At the start: no step lies behind.
   subroutine begin_work(self, done, power)
      class(work_type), intent(inout) :: self
      !> Work so far, power
      real(wp), intent(in) :: done, power
      self%before = done
      self%done = done
      self%power = power
      self%power_before = power
      self%length = 0.0_wp
      self%shape = 0.0_wp
      self%refused = 0.0_wp
   end subroutine begin_work

   !> A step of length h from the powers at the three stages of Radau's method, eq. (5.35): the cubic through these and the power at
   !> the beginning, whose integral over the step is that of the method. The error is what the power at the beginning changes
   !> within the step, of order 4.
   subroutine try_stages(self, h, power, energy, err)
      class(work_type), intent(inout) :: self
      real(wp), intent(in) :: h, power(3)
      !> Of the motion [energy]
      real(wp), intent(in) :: energy
      !> In units of the scale
      real(wp), intent(out) :: err
      !> Three times the largest integral from 0 of (s - c1)(s - c2)(s - c3)
      real(wp), parameter :: most = 2.0e-2_wp
      real(wp) :: first(3), second(2), third, b(4)
      first = [(power(1) - self%power)/c(1), (power(2) - power(1))/(c(2) - c(1)), (power(3) - power(2))/(c(3) - c(2))]
      second = [(first(2) - first(1))/c(2), (first(3) - first(2))/(c(3) - c(1))]
      third = (second(2) - second(1))/c(3)
      ! P0 + s f1 + s (s - c1) f2 + s (s - c1)(s - c2) f3, by powers of s
      b(1) = self%power
      b(2) = first(1) - c(1)*second(1) + c(1)*c(2)*third
      b(3) = second(1) - (c(1) + c(2))*third
      b(4) = third
      self%new_shape = h*b*[1.0_wp, 0.5_wp, 1.0_wp/3, 0.25_wp]
      err = h*most*abs(third)/scale_of(self, energy, h*maxval(abs(power)))
   end subroutine try_stages

   !> A step of length h from the powers at its ends and at the beginning of the step before, eq. (5.36). The error is what
   !> that changes, of order 3.
   subroutine try_ends(self, h, power, energy, err)
      class(work_type), intent(inout) :: self
      !> Length; power at the end; energy of the motion
      real(wp), intent(in) :: h, power, energy
      real(wp), intent(out) :: err
      real(wp) :: rise, bend
      rise = power - self%power
      if (self%length > 0.0_wp) then
         bend = (rise - (self%power - self%power_before)*h/self%length)/(1 + self%length/h)
         err = h*abs(bend)/6/scale_of(self, energy, h*max(abs(self%power), abs(power)))
      else
         bend = 0.0_wp
         err = h*abs(rise)/6/max(self%throughput + h*max(abs(self%power), abs(power)), energy, tiny(h))
      end if
      self%new_shape = h*[self%power, 0.5_wp*(rise - bend), bend/3, 0.0_wp]
   end subroutine try_ends

   !> A step of length h whose work is known: the cubic through work and power at both ends.
   subroutine try_cubic(self, h, power, done)
      class(work_type), intent(inout) :: self
      !> Length; power at the end; work in the step
      real(wp), intent(in) :: h, power, done
      self%new_shape = [h*self%power, 3*done - h*(2*self%power + power), h*(self%power + power) - 2*done, 0.0_wp]
   end subroutine try_cubic

   !> A step whose work is known, taken as even: what its forces do, and what they miss of the work of their laws.
   subroutine try_known(self, done, missed)
      class(work_type), intent(inout) :: self
      real(wp), intent(in) :: done, missed
      self%new_shape = [done + missed, 0.0_wp, 0.0_wp, 0.0_wp]
      self%new_missed = missed
   end subroutine try_known

   !> Scale of the work, eq. (5.37): what has gone through so far, this step included, or less where it goes to and fro and its
   !> errors add up; below it a part of the energy of the motion, or all of it where nobody asks.
   pure real(wp) function scale_of(self, energy, step)
      class(work_type), intent(in) :: self
      !> Energy of the motion; what goes through in the step
      real(wp), intent(in) :: energy, step
      real(wp) :: most
      scale_of = self%throughput + step
      most = few*(self%largest + step)
      if (self%asked .and. most < scale_of) scale_of = most**2/scale_of
      if (self%asked) scale_of = max(scale_of, round_off*max(step, self%passing))
      scale_of = max(scale_of, merge(floor_asked, 1.0_wp, self%asked)*energy, tiny(energy))
   end function scale_of

   !> Notes what has gone through in a step, and the work after it.
   pure subroutine note_passing(self, passing, done)
      class(work_type), intent(inout) :: self
      real(wp), intent(in) :: passing, done
      self%passing = passing
      self%throughput = self%throughput + passing
      self%largest = max(self%largest, abs(done))
   end subroutine note_passing

   !> The tolerance of the work.
   pure real(wp) function allowed(self, tolerance)
      class(work_type), intent(in) :: self
      !> Of the motion
      real(wp), intent(in) :: tolerance
      allowed = tolerance
      if (.not. self%asked) allowed = max(tolerance, for_balance)
   end function allowed

   !> Whether the work of the step that is tried is exact enough; one that a shorter step has not made better is taken as it is.
   logical function is_within(self, err, bound)
      class(work_type), intent(inout) :: self
      !> Error, and the largest that a step may have, in units of the scale
      real(wp), intent(in) :: err, bound
      is_within = err <= bound
      if (.not. is_within .and. self%refused > 0.0_wp) is_within = err > stubborn*self%refused
      self%refused = merge(0.0_wp, err, is_within)
   end function is_within

   !> Whether nobody asks for the work, and the balance of energy is no better than the motion.
   pure logical function is_rough(self, tolerance)
      class(work_type), intent(in) :: self
      !> Of the motion
      real(wp), intent(in) :: tolerance
      is_rough = .not. self%asked .and. tolerance > for_balance
   end function is_rough

   !> Takes the step that is tried.
   subroutine accept(self, h, power)
      class(work_type), intent(inout) :: self
      !> Length; power at the end
      real(wp), intent(in) :: h, power
      self%shape = self%new_shape
      self%missed = self%missed + self%new_missed
      self%before = self%done
      self%done = self%before + sum(self%shape)
      call self%note_passing(0.5_wp*h*(abs(self%power) + abs(power)), self%done)
      self%power_before = self%power
      self%power = power
      self%length = h
   end subroutine accept

   !> Work put in at a part of the last step.
   pure real(wp) function within(self, part)
      class(work_type), intent(in) :: self
      !> 0 to 1
      real(wp), intent(in) :: part
      within = self%before + part*(self%shape(1) + part*(self%shape(2) + part*(self%shape(3) + part*self%shape(4))))
   end function within

   !> Saves or restores its memory.
   subroutine exchange_work(self, snapshot)
      class(work_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('work_before', self%before)
      call snapshot%exchange('work_done', self%done)
      call snapshot%exchange('power', self%power)
      call snapshot%exchange('power_before', self%power_before)
      call snapshot%exchange('work_length', self%length)
      call snapshot%exchange('work_shape', self%shape)
      call snapshot%exchange('missed', self%missed)
      call snapshot%exchange('passing', self%passing)
      call snapshot%exchange('throughput', self%throughput)
      call snapshot%exchange('largest_work', self%largest)
      call snapshot%exchange('refused', self%refused)
      ! Not saved: asked, new_shape, new_missed
   end subroutine exchange_work

end module limber_integrator_work_integral
