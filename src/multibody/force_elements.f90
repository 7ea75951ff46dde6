!> Loads along scalar functions, linear or by laws. A force along a function is linear in it, or a law of it, of its rate, of other
!> functions and of time. Springs of any characteristic, actuators, bushings, friction, torques of sections and between bodies,
!> follower forces and controllers are made of it. Floor: multibody. Source: doc/theory, eqs. (3.34)-(3.36).
module limber_multibody_force_elements
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   use limber_model_model, only: most_slots
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_law_means, only: mean_law, find_law_mean
   use limber_multibody_load, only: load_type
   use limber_multibody_markers, only: add_marker, marker_stiffness, marker_column, drift_column
   use limber_multibody_scalar_functions, only: scalar_function_type, scalar_distance, read_function, read_gap, function_ends, &
      & function_hessian, hessian_times
   implicit none
   private
   public :: force_element_type, max_slots

   !> Most scalar functions of a load, and most things that its law depends on
   integer, parameter :: max_scalars = most_slots + 1, max_slots = most_slots

   !> A force  f = -k s - c s' + factor law(s, s', other functions and rates, t)  along the first function s: the generalised forces
   !> are f times its gradient. A follower acts on the first marker only, along the direction.
   type, extends(load_type) :: force_element_type
      !> The first is that along which it acts
      type(scalar_function_type), allocatable :: functions(:)
      logical :: follower = .false.
      !> k, c, and what the law is multiplied by
      real(wp) :: stiffness = 0.0_wp, damping = 0.0_wp, factor = 0.0_wp
      !> Whether there is a law; whether it is a function of s alone, so that its work over a step follows from the ends; and
      !> whether that counts as an energy that it stores
      logical :: driven = .false., potential = .false., stores = .false.
      type(expression_type) :: law
      !> The value of s that the energy is counted from
      real(wp) :: origin = 0.0_wp
      !> What each slot of the law stands for: a function, or 0 for the time; and whether its rate is meant
      integer, allocatable :: slots(:)
      logical, allocatable :: by_rate(:)
      !> Of a law of s alone: each slot is sign s + shift
      real(wp), allocatable :: sign(:), shift(:)
   contains
      procedure :: add_force => element_add_force
      procedure :: add_tangent => element_add_tangent
      procedure :: add_elasticity => element_add_elasticity
      procedure :: add_energy => element_add_energy
      procedure :: energy_doubt => element_energy_doubt
      procedure :: begin_energy => element_begin_energy
      procedure :: add_power => element_add_power
      procedure :: add_missed_power => element_add_missed_power
      procedure :: add_missed_force => element_add_missed_force
      procedure :: state_along => element_state_along
      procedure :: force_along
      procedure :: read_motion
   end type force_element_type

contains

   pure subroutine element_add_force(self, kinematics, force)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: force(:)
      real(wp) :: value, rate, push, weights(2, 3)
      integer :: m, part
      call self%force_along(kinematics, value, rate, push, weights)
      do m = 1, merge(1, 3, self%follower)
         part = self%functions(1)%parts(m)
         if (part == 0) cycle
         call add_marker(kinematics%markers(self%functions(1)%markers(m)), push*weights(:, m), &
            & force(self%offsets(part) + 1:self%offsets(part) + self%rates(part)))
      end do
   end subroutine element_add_force

   !> The function that the load acts along, its rate and the force along it; kinematics are placed and moved. Over a step the part
   !> that has an energy is its mean over the values between the ends, the rest is that of the mean.
   pure subroutine force_along(self, kinematics, value, rate, push, weights)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      !> s, s', f
      real(wp), intent(out) :: value, rate, push
      !> Derivatives of s by the positions of its markers (2, 3)
      real(wp), intent(out) :: weights(2, 3)
      real(wp) :: ends(2)
      call read_function(self%functions(1), kinematics, value, rate, weights)
      if (self%follower) rate = dot_product(weights(:, 1), kinematics%markers(self%functions(1)%markers(1))%velocity)
      push = -self%stiffness*value - self%damping*rate
      if (.not. self%driven) return
      if (self%potential .and. kinematics%span > 0.0_wp) then
         call function_ends(self%functions(1), kinematics, ends(1), ends(2))
         push = push + self%factor*mean_law(self%law, self%sign, self%shift, ends(1), ends(2))
      else
         push = push + self%factor*law_value(self, kinematics)
      end if
   end subroutine force_along

   !> The scalar, its rate and the force along it.
   pure subroutine element_state_along(self, kinematics, value, rate, push)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: value, rate, push
      real(wp) :: weights(2, 3)
      call self%force_along(kinematics, value, rate, push, weights)
   end subroutine element_state_along

   !> The law at the values and rates of its functions.
   pure real(wp) function law_value(self, kinematics) result(value)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: values(max_slots), weights(2, 3, max_scalars)
      call read_slots(self, kinematics, values, weights)
      value = self%law%evaluate(values(:size(self%slots)))
   end function law_value

   !> Values of the slots of the law, and the weights of all functions.
   pure subroutine read_slots(self, kinematics, values, weights)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: values(max_slots), weights(2, 3, max_scalars)
      real(wp) :: scalars(max_scalars), rates(max_scalars)
      integer :: k
      do k = 1, size(self%functions)
         call read_function(self%functions(k), kinematics, scalars(k), rates(k), weights(:, :, k))
      end do
      values = 0.0_wp
      do k = 1, size(self%slots)
         values(k) = kinematics%time
         if (self%slots(k) == 0) cycle
         values(k) = scalars(self%slots(k))
         if (self%by_rate(k)) values(k) = rates(self%slots(k))
      end do
   end subroutine read_slots

   !> What the slots of the law are in a motion, and how fast they change; of a slot that is a rate, the function and its rate; of
   !> one that is a distance, or its rate, also the vector.
   pure subroutine read_motion(self, kinematics, place, rate, gap, drift)
      class(force_element_type), intent(in) :: self
      !> Placed and moved
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: place(:), rate(:)
      !> The vector and its rate (2, slots); unchanged for all else
      real(wp), intent(inout) :: gap(:, :), drift(:, :)
      real(wp) :: weights(2, 3)
      integer :: k
      do k = 1, size(self%slots)
         place(k) = kinematics%time
         rate(k) = 1.0_wp
         if (self%slots(k) == 0) cycle
         associate (scalar => self%functions(self%slots(k)))
            call read_function(scalar, kinematics, place(k), rate(k), weights)
            if (scalar%kind == scalar_distance) call read_gap(scalar, kinematics, gap(:, k), drift(:, k))
         end associate
      end do
   end subroutine read_motion

   !> With s_y the gradient of the function, s_yy its second derivatives and those of its markers, and f_y, f_w the derivatives of
   !> the force by coordinates and rates: the stiffness is -s_y f_y - f s_yy, the damping -s_y f_w.
   pure subroutine element_add_tangent(self, kinematics, stiffness, damping)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
      real(wp) :: weights(2, 3, max_scalars), push(2, 3, max_scalars), by_value(max_scalars), by_rate(max_scalars)
      real(wp) :: h(2, 3, 2, 3), value, rate, force, along(2, 3), column(2, 3), slope, drag, row
      integer :: i, j, p, q, m, n, most
      call self%force_along(kinematics, value, rate, force, along)
      call force_derivatives(self, kinematics, weights, push, by_value, by_rate, h)
      most = merge(1, 3, self%follower)
      if (self%follower) h(:, 3, :, :) = 0.0_wp
      do q = 1, size(self%rates)
         do j = 1, self%rates(q)
            call along_coordinate(self, kinematics, weights, push, by_value, by_rate, q, j, slope, drag)
            do m = 1, most
               column(:, m) = 0.0_wp
               do n = 1, 3
                  column(:, m) = column(:, m) + hessian_times(h, m, n, function_column(self%functions(1), kinematics, n, q, j))
               end do
               column(:, m) = along(:, m)*slope + force*column(:, m)
            end do
            do p = 1, size(self%rates)
               do i = 1, self%rates(p)
                  row = 0.0_wp
                  do m = 1, most
                     row = row + dot_product(along(:, m), function_column(self%functions(1), kinematics, m, p, i))
                     stiffness(self%offsets(p) + i, self%offsets(q) + j) = stiffness(self%offsets(p) + i, self%offsets(q) + j) &
                        & - dot_product(column(:, m), function_column(self%functions(1), kinematics, m, p, i))
                  end do
                  damping(self%offsets(p) + i, self%offsets(q) + j) = damping(self%offsets(p) + i, self%offsets(q) + j) - row*drag
               end do
            end do
         end do
      end do
      do m = 1, most
         p = self%functions(1)%parts(m)
         if (p == 0) cycle
         call marker_stiffness(kinematics, self%functions(1)%markers(m), -force*along(:, m), &
            & stiffness(self%offsets(p) + 1:self%offsets(p) + self%rates(p), self%offsets(p) + 1:self%offsets(p) + self%rates(p)))
      end do
   end subroutine element_add_tangent

   !> Of the linear part, along the function.
   pure subroutine element_add_elasticity(self, kinematics, stiffness)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: stiffness(:, :)
      real(wp) :: weights(2, 3), gradient(size(stiffness, 1)), value, rate
      integer :: j, m, p
      if (self%follower .or. .not. self%stiffness > 0.0_wp) return
      call read_function(self%functions(1), kinematics, value, rate, weights)
      gradient = 0.0_wp
      do p = 1, size(self%rates)
         do j = 1, self%rates(p)
            do m = 1, 3
               gradient(self%offsets(p) + j) = gradient(self%offsets(p) + j) &
                  & + dot_product(weights(:, m), function_column(self%functions(1), kinematics, m, p, j))
            end do
         end do
      end do
      do j = 1, size(gradient)
         stiffness(:, j) = stiffness(:, j) + self%stiffness*gradient(j)*gradient
      end do
   end subroutine element_add_elasticity

   !> Derivative of the force by one coordinate and by its rate.
   pure subroutine along_coordinate(self, kinematics, weights, push, by_value, by_rate, part, j, slope, drag)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: weights(2, 3, max_scalars), push(2, 3, max_scalars), by_value(max_scalars), by_rate(max_scalars)
      integer, intent(in) :: part, j
      real(wp), intent(out) :: slope, drag
      real(wp) :: by_place, drift
      integer :: k
      slope = 0.0_wp
      drag = 0.0_wp
      do k = 1, size(self%functions)
         call function_drift(self%functions(k), kinematics, weights(:, :, k), push(:, :, k), part, j, by_place, drift)
         slope = slope + by_value(k)*by_place + by_rate(k)*drift
         drag = drag + by_rate(k)*by_place
      end do
   end subroutine along_coordinate

   !> Derivatives of the force by the values and rates of all functions; weights of these, their second derivatives
   !> times velocities, and the second derivatives of the first.
   pure subroutine force_derivatives(self, kinematics, weights, push, by_value, by_rate, h)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: weights(2, 3, max_scalars), push(2, 3, max_scalars), by_value(max_scalars), by_rate(max_scalars)
      real(wp), intent(out) :: h(2, 3, 2, 3)
      type(jet_type) :: line(max_slots), jet
      real(wp) :: values(max_slots)
      integer :: k, m, n
      call read_slots(self, kinematics, values, weights)
      do k = 1, size(self%slots)
         line(k)%value = values(k)
      end do
      by_value = 0.0_wp
      by_rate = 0.0_wp
      by_value(1) = -self%stiffness
      by_rate(1) = -self%damping
      do k = 1, size(self%slots)
         if (self%slots(k) == 0) cycle
         line(k)%first = 1.0_wp
         jet = self%law%evaluate_along(line(:size(self%slots)))
         line(k)%first = 0.0_wp
         if (self%by_rate(k)) then
            by_rate(self%slots(k)) = by_rate(self%slots(k)) + self%factor*jet%first
         else
            by_value(self%slots(k)) = by_value(self%slots(k)) + self%factor*jet%first
         end if
      end do
      if (self%potential .and. kinematics%span > 0.0_wp) call end_slope(self, kinematics, by_value)
      push = 0.0_wp
      do k = size(self%functions), 1, -1
         call function_hessian(self%functions(k), kinematics, h)
         do n = 1, 3
            if (self%functions(k)%markers(n) == 0) cycle
            do m = 1, 3
               push(:, m, k) = push(:, m, k) + hessian_times(h, m, n, kinematics%markers(self%functions(k)%markers(n))%velocity)
            end do
         end do
      end do
   end subroutine force_derivatives

   !> Over a step twice the derivative of the mean of a law of s alone by s at the end, in place of that at the middle, from which
   !> it differs much where the law bends within the step.
   pure subroutine end_slope(self, kinematics, by_value)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      !> Derivatives by the functions; left as they are where the step is too short
      real(wp), intent(inout) :: by_value(:)
      real(wp), parameter :: short = 1.0e-6_wp
      real(wp) :: ends(2), values(max_slots)
      call function_ends(self%functions(1), kinematics, ends(1), ends(2))
      if (abs(ends(2) - ends(1)) <= short*maxval(abs(ends))) return
      values(:size(self%sign)) = self%sign*ends(2) + self%shift
      by_value = 0.0_wp
      by_value(1) = 2*self%factor*(self%law%evaluate(values(:size(self%sign))) - mean_law(self%law, self%sign, self%shift, &
         & ends(1), ends(2)))/(ends(2) - ends(1)) - self%stiffness
   end subroutine end_slope

   !> Derivative of a marker's position by one of the stacked coordinates of a load's bodies (2).
   pure function function_column(scalar, kinematics, m, part, j) result(column)
      type(scalar_function_type), intent(in) :: scalar
      type(kinematics_type), intent(in) :: kinematics
      !> Which marker of the function
      integer, intent(in) :: m
      !> Which of the load's bodies, and which of its coordinates
      integer, intent(in) :: part, j
      real(wp) :: column(2)
      column = 0.0_wp
      if (scalar%parts(m) == part .and. part > 0) column = marker_column(kinematics%markers(scalar%markers(m)), j)
   end function function_column

   !> Derivative of a function and of its rate by one of the stacked coordinates of a load's bodies.
   pure subroutine function_drift(scalar, kinematics, weights, push, part, j, by_place, drift)
      type(scalar_function_type), intent(in) :: scalar
      type(kinematics_type), intent(in) :: kinematics
      !> Weights, and second derivatives times velocities (2, 3)
      real(wp), intent(in) :: weights(2, 3), push(2, 3)
      integer, intent(in) :: part, j
      real(wp), intent(out) :: by_place, drift
      real(wp) :: column(2)
      integer :: m
      by_place = 0.0_wp
      drift = 0.0_wp
      if (part == 0) return
      do m = 1, 3
         if (scalar%parts(m) /= part) cycle
         column = marker_column(kinematics%markers(scalar%markers(m)), j)
         by_place = by_place + dot_product(weights(:, m), column)
         drift = drift + dot_product(push(:, m), column) &
            & + dot_product(weights(:, m), drift_column(kinematics, scalar%markers(m), j))
      end do
   end subroutine function_drift

   pure subroutine element_add_energy(self, kinematics, sum)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
      real(wp) :: value, rate, weights(2, 3), mean, open
      if (.not. (self%stores .or. self%stiffness > 0.0_wp)) return
      call read_function(self%functions(1), kinematics, value, rate, weights)
      sum = sum + 0.5_wp*self%stiffness*value**2
      if (.not. self%stores) return
      call find_law_mean(self%law, self%sign, self%shift, self%origin, value, .true., mean, open)
      sum = sum - self%factor*(value - self%origin)*mean
   end subroutine element_add_energy

   !> What the integral of a law may be off by, where it comes and goes too often.
   pure real(wp) function element_energy_doubt(self, kinematics) result(doubt)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: value, rate, weights(2, 3), mean, open
      doubt = 0.0_wp
      if (.not. self%stores) return
      call read_function(self%functions(1), kinematics, value, rate, weights)
      call find_law_mean(self%law, self%sign, self%shift, self%origin, value, .true., mean, open, doubt)
      doubt = abs(self%factor*(value - self%origin))*doubt
   end function element_energy_doubt

   !> The energy of a law is its integral from zero, or from the first value where that does not exist, as of 1/s.
   pure subroutine element_begin_energy(self, kinematics)
      class(force_element_type), intent(inout) :: self
      type(kinematics_type), intent(in) :: kinematics
      !> Part of the integral in intervals that could not be made small enough
      real(wp), parameter :: nothing = 1.0e-9_wp
      real(wp) :: value, rate, weights(2, 3), mean, open
      if (.not. self%stores) return
      call read_function(self%functions(1), kinematics, value, rate, weights)
      call find_law_mean(self%law, self%sign, self%shift, 0.0_wp, value, .true., mean, open)
      self%origin = merge(0.0_wp, value, open <= nothing*min(abs(mean), huge(mean)))
   end subroutine element_begin_energy

   !> All but what comes from the energy.
   pure subroutine element_add_power(self, kinematics, sum)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
      real(wp) :: value, rate, push, weights(2, 3)
      if (.not. self%powered) return
      call self%force_along(kinematics, value, rate, push, weights)
      if (self%stores) then
         sum = sum - self%damping*rate**2
      else
         sum = sum + (push + self%stiffness*value)*rate
      end if
   end subroutine element_add_power

   !> Of all that is neither linear in s nor a law of it alone: these the step has exactly.
   pure subroutine element_add_missed_power(self, mean, now, sum)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(inout) :: sum
      real(wp) :: value, rate, push, weights(2, 3), value_now, rate_now, push_now
      call self%force_along(mean, value, rate, push, weights)
      call self%force_along(now, value_now, rate_now, push_now, weights)
      if (self%potential) then
         sum = sum - self%damping*(rate_now - rate)*rate_now
      else if (self%follower) then
         sum = sum + push_now*rate_now - push*rate
      else
         sum = sum + (push_now + self%stiffness*value_now - push - self%stiffness*value)*rate_now
      end if
   end subroutine element_add_missed_power

   !> Of the law, unless it has an energy.
   pure subroutine element_add_missed_force(self, mean, now, part, force)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(in) :: part
      real(wp), intent(inout) :: force(:)
      real(wp) :: value, rate, push, weights(2, 3)
      integer :: m, k
      if (self%potential .or. .not. self%driven) return
      call read_function(self%functions(1), mean, value, rate, weights)
      push = part*self%factor*(law_value(self, now) - law_value(self, mean))
      do m = 1, merge(1, 3, self%follower)
         k = self%functions(1)%parts(m)
         if (k == 0) cycle
         call add_marker(mean%markers(self%functions(1)%markers(m)), push*weights(:, m), &
            & force(self%offsets(k) + 1:self%offsets(k) + self%rates(k)))
      end do
   end subroutine element_add_missed_force


end module limber_multibody_force_elements
