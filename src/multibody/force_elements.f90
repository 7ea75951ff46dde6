!> Loads along scalar functions, linear or by laws. A force along a gauge, linear in it or a law of it, of its rate, of other gauges
!> and of time. Springs of any characteristic, actuators, bushings, friction, torques of sections and between bodies, follower
!> forces and controllers are made of it. Floor: multibody. Source: doc/theory, eqs. (3.34)-(3.36).
module limber_multibody_force_elements
   use, intrinsic :: ieee_exceptions, only: ieee_get_halting_mode, ieee_set_halting_mode, ieee_get_flag, ieee_set_flag, &
      & ieee_all
   use limber_base_kinds, only: wp, long
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   use limber_deck_range, only: range_type, law_range_over
   use limber_model_model, only: most_slots
   use limber_multibody_load_functions, only: load_function_type, gauge_distance, read_gauge, read_gap, gauge_ends, &
      & gauge_curvature, &
      & gauge_column, &
      & gauge_drift
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_load, only: load_type
   use limber_multibody_markers, only: add_marker, marker_stiffness
   implicit none
   private
   public :: force_element_type, max_slots

   !> Most gauges of a load, and most things that its law depends on
   integer, parameter :: max_gauges = most_slots + 1, max_slots = most_slots
   !> Gauss points and weights on -1..1, how often an interval is halved at most, and how many may be rough: in a step, and of an
   !> energy
   real(wp), parameter :: gauss(5) = [-0.906179845938663993_wp, -0.538469310105683091_wp, 0.0_wp, 0.538469310105683091_wp, &
      & 0.906179845938663993_wp]
   real(wp), parameter :: gauss_weights(5) = [0.236926885056189088_wp, 0.478628670499366468_wp, 0.568888888888888889_wp, &
      & 0.478628670499366468_wp, 0.236926885056189088_wp]
   integer, parameter :: deepest = 40, few_rough = 64, most_rough = 1024

   !> A force  f = -k s - c s' + factor law(s, s', other gauges and rates, t)  along the first gauge s: the generalised forces are f
   !> times its gradient. A follower acts on the first marker only, along the direction.
   type, extends(load_type) :: force_element_type
      !> The first is that along which it acts
      type(load_function_type), allocatable :: gauges(:)
      logical :: follower = .false.
      !> k, c, and what the law is multiplied by
      real(wp) :: stiffness = 0.0_wp, damping = 0.0_wp, factor = 0.0_wp
      !> Whether there is a law; whether it is a function of s alone, so that its work over a step follows from the ends; and whether
      !> that counts as an energy that it stores
      logical :: driven = .false., potential = .false., stores = .false.
      type(expression_type) :: law
      !> The value of s that the energy is counted from
      real(wp) :: origin = 0.0_wp
      !> What each slot of the law stands for: a gauge, or 0 for the time; and whether its rate is meant
      integer, allocatable :: slots(:)
      logical, allocatable :: by_rate(:)
      !> Of a law of s alone: each slot is sign s + shift
      real(wp), allocatable :: sign(:), shift(:)
   contains
      procedure :: add_force => effort_add_force
      procedure :: add_tangent => effort_add_tangent
      procedure :: add_elasticity => effort_add_elasticity
      procedure :: add_energy => effort_add_energy
      procedure :: energy_doubt => effort_energy_doubt
      procedure :: begin_energy => effort_begin_energy
      procedure :: add_power => effort_add_power
      procedure :: add_missed_power => effort_add_missed_power
      procedure :: add_missed_force => effort_add_missed_force
      procedure :: state_along => effort_state
      procedure :: measure
      procedure :: read_motion
   end type force_element_type

contains

   pure subroutine effort_add_force(self, kinematics, force)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: force(:)
      real(wp) :: value, rate, push, weights(2, 3)
      integer :: m, part
      call self%measure(kinematics, value, rate, push, weights)
      do m = 1, merge(1, 3, self%follower)
         part = self%gauges(1)%parts(m)
         if (part == 0) cycle
         call add_marker(kinematics%markers(self%gauges(1)%markers(m)), push*weights(:, m), &
            & force(self%offsets(part) + 1:self%offsets(part) + self%rates(part)))
      end do
   end subroutine effort_add_force

   !> The gauge that the load acts along, its rate and the force along it; kinematics are placed and moved. Over a step the part
   !> that has an energy is its mean over the values between the ends, the rest is that of the mean.
   pure subroutine measure(self, kinematics, value, rate, push, weights)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      !> s, s', f
      real(wp), intent(out) :: value, rate, push
      !> Derivatives of s by the positions of its markers (2, 3)
      real(wp), intent(out) :: weights(2, 3)
      real(wp) :: ends(2)
      call read_gauge(self%gauges(1), kinematics, value, rate, weights)
      if (self%follower) rate = dot_product(weights(:, 1), kinematics%markers(self%gauges(1)%markers(1))%velocity)
      push = -self%stiffness*value - self%damping*rate
      if (.not. self%driven) return
      if (self%potential .and. kinematics%span > 0.0_wp) then
         call gauge_ends(self%gauges(1), kinematics, ends(1), ends(2))
         push = push + self%factor*mean_law(self%law, self%sign, self%shift, ends(1), ends(2))
      else
         push = push + self%factor*law_value(self, kinematics)
      end if
   end subroutine measure

   !> The scalar, its rate and the force along it.
   pure subroutine effort_state(self, kinematics, value, rate, push)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: value, rate, push
      real(wp) :: weights(2, 3)
      call self%measure(kinematics, value, rate, push, weights)
   end subroutine effort_state

   !> The law at the values and rates of its gauges.
   pure real(wp) function law_value(self, kinematics) result(value)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: values(max_slots), weights(2, 3, max_gauges)
      call read_slots(self, kinematics, values, weights)
      value = self%law%evaluate(values(:size(self%slots)))
   end function law_value

   !> Values of the slots of the law, and the weights of all gauges.
   pure subroutine read_slots(self, kinematics, values, weights)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: values(max_slots), weights(2, 3, max_gauges)
      real(wp) :: gauges(max_gauges), rates(max_gauges)
      integer :: k
      do k = 1, size(self%gauges)
         call read_gauge(self%gauges(k), kinematics, gauges(k), rates(k), weights(:, :, k))
      end do
      values = 0.0_wp
      do k = 1, size(self%slots)
         values(k) = kinematics%time
         if (self%slots(k) == 0) cycle
         values(k) = gauges(self%slots(k))
         if (self%by_rate(k)) values(k) = rates(self%slots(k))
      end do
   end subroutine read_slots

   !> What the slots of the law are in a motion, and how fast they change; of a slot that is a rate, the gauge and its rate; of one that
   !> is a distance, or its rate, also the vector.
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
         associate (gauge => self%gauges(self%slots(k)))
            call read_gauge(gauge, kinematics, place(k), rate(k), weights)
            if (gauge%kind == gauge_distance) call read_gap(gauge, kinematics, gap(:, k), drift(:, k))
         end associate
      end do
   end subroutine read_motion

   !> With s_y the gradient of the gauge, s_yy what the curvature of its markers and of itself makes, and f_y, f_w the derivatives
   !> of the force by coordinates and rates: the stiffness is -s_y f_y - f s_yy, the damping -s_y f_w.
   pure subroutine effort_add_tangent(self, kinematics, stiffness, damping)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
      real(wp) :: weights(2, 3, max_gauges), push(2, 3, max_gauges), by_value(max_gauges), by_rate(max_gauges)
      real(wp) :: curvature(2, 3, 2, 3), value, rate, force, along(2, 3), column(2, 3), slope, drag, row
      integer :: i, j, p, q, m, n, most
      call self%measure(kinematics, value, rate, force, along)
      call force_derivatives(self, kinematics, weights, push, by_value, by_rate, curvature)
      most = merge(1, 3, self%follower)
      if (self%follower) curvature(:, 3, :, :) = 0.0_wp
      do q = 1, size(self%rates)
         do j = 1, self%rates(q)
            call along_coordinate(self, kinematics, weights, push, by_value, by_rate, q, j, slope, drag)
            do m = 1, most
               column(:, m) = 0.0_wp
               do n = 1, 3
                  column(:, m) = column(:, m) + times(curvature, m, n, gauge_column(self%gauges(1), kinematics, n, q, j))
               end do
               column(:, m) = along(:, m)*slope + force*column(:, m)
            end do
            do p = 1, size(self%rates)
               do i = 1, self%rates(p)
                  row = 0.0_wp
                  do m = 1, most
                     row = row + dot_product(along(:, m), gauge_column(self%gauges(1), kinematics, m, p, i))
                     stiffness(self%offsets(p) + i, self%offsets(q) + j) = stiffness(self%offsets(p) + i, self%offsets(q) + j) &
                        & - dot_product(column(:, m), gauge_column(self%gauges(1), kinematics, m, p, i))
                  end do
                  damping(self%offsets(p) + i, self%offsets(q) + j) = damping(self%offsets(p) + i, self%offsets(q) + j) - row*drag
               end do
            end do
         end do
      end do
      do m = 1, most
         p = self%gauges(1)%parts(m)
         if (p == 0) cycle
         call marker_stiffness(kinematics, self%gauges(1)%markers(m), -force*along(:, m), &
            & stiffness(self%offsets(p) + 1:self%offsets(p) + self%rates(p), self%offsets(p) + 1:self%offsets(p) + self%rates(p)))
      end do
   end subroutine effort_add_tangent

   !> Of the linear part, along the gauge.
   pure subroutine effort_add_elasticity(self, kinematics, stiffness)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: stiffness(:, :)
      real(wp) :: weights(2, 3), gradient(size(stiffness, 1)), value, rate
      integer :: j, m, p
      if (self%follower .or. .not. self%stiffness > 0.0_wp) return
      call read_gauge(self%gauges(1), kinematics, value, rate, weights)
      gradient = 0.0_wp
      do p = 1, size(self%rates)
         do j = 1, self%rates(p)
            do m = 1, 3
               gradient(self%offsets(p) + j) = gradient(self%offsets(p) + j) &
                  & + dot_product(weights(:, m), gauge_column(self%gauges(1), kinematics, m, p, j))
            end do
         end do
      end do
      do j = 1, size(gradient)
         stiffness(:, j) = stiffness(:, j) + self%stiffness*gradient(j)*gradient
      end do
   end subroutine effort_add_elasticity

   !> Derivative of the force by one coordinate and by its rate.
   pure subroutine along_coordinate(self, kinematics, weights, push, by_value, by_rate, part, j, slope, drag)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: weights(2, 3, max_gauges), push(2, 3, max_gauges), by_value(max_gauges), by_rate(max_gauges)
      integer, intent(in) :: part, j
      real(wp), intent(out) :: slope, drag
      real(wp) :: by_place, drift
      integer :: k
      slope = 0.0_wp
      drag = 0.0_wp
      do k = 1, size(self%gauges)
         call gauge_drift(self%gauges(k), kinematics, weights(:, :, k), push(:, :, k), part, j, by_place, drift)
         slope = slope + by_value(k)*by_place + by_rate(k)*drift
         drag = drag + by_rate(k)*by_place
      end do
   end subroutine along_coordinate

   !> Derivatives of the force by the values and rates of all gauges; weights of these, their curvature times velocities, and the
   !> curvature of the first.
   pure subroutine force_derivatives(self, kinematics, weights, push, by_value, by_rate, curvature)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: weights(2, 3, max_gauges), push(2, 3, max_gauges), by_value(max_gauges), by_rate(max_gauges)
      real(wp), intent(out) :: curvature(2, 3, 2, 3)
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
      do k = size(self%gauges), 1, -1
         call gauge_curvature(self%gauges(k), kinematics, curvature)
         do n = 1, 3
            if (self%gauges(k)%markers(n) == 0) cycle
            do m = 1, 3
               push(:, m, k) = push(:, m, k) + times(curvature, m, n, kinematics%markers(self%gauges(k)%markers(n))%velocity)
            end do
         end do
      end do
   end subroutine force_derivatives

   !> Over a step twice the derivative of the mean of a law of s alone by s at the end, in place of that at the middle, from which
   !> it differs much where the law bends within the step.
   pure subroutine end_slope(self, kinematics, by_value)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      !> Derivatives by the gauges; left as they are where the step is too short
      real(wp), intent(inout) :: by_value(:)
      real(wp), parameter :: short = 1.0e-6_wp
      real(wp) :: ends(2), values(max_slots)
      call gauge_ends(self%gauges(1), kinematics, ends(1), ends(2))
      if (abs(ends(2) - ends(1)) <= short*maxval(abs(ends))) return
      values(:size(self%sign)) = self%sign*ends(2) + self%shift
      by_value = 0.0_wp
      by_value(1) = 2*self%factor*(self%law%evaluate(values(:size(self%sign))) - mean_law(self%law, self%sign, self%shift, &
         & ends(1), ends(2)))/(ends(2) - ends(1)) - self%stiffness
   end subroutine end_slope

   !> A block of a curvature times a vector.
   pure function times(curvature, m, n, vector) result(product)
      real(wp), intent(in) :: curvature(2, 3, 2, 3)
      !> Markers
      integer, intent(in) :: m, n
      real(wp), intent(in) :: vector(2)
      real(wp) :: product(2)
      product = curvature(:, m, 1, n)*vector(1) + curvature(:, m, 2, n)*vector(2)
   end function times

   pure subroutine effort_add_energy(self, kinematics, sum)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
      real(wp) :: value, rate, weights(2, 3), mean, open
      if (.not. (self%stores .or. self%stiffness > 0.0_wp)) return
      call read_gauge(self%gauges(1), kinematics, value, rate, weights)
      sum = sum + 0.5_wp*self%stiffness*value**2
      if (.not. self%stores) return
      call find_mean(self%law, self%sign, self%shift, self%origin, value, .true., mean, open)
      sum = sum - self%factor*(value - self%origin)*mean
   end subroutine effort_add_energy

   !> What the integral of a law may be off by, where it comes and goes too often.
   pure real(wp) function effort_energy_doubt(self, kinematics) result(doubt)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: value, rate, weights(2, 3), mean, open
      doubt = 0.0_wp
      if (.not. self%stores) return
      call read_gauge(self%gauges(1), kinematics, value, rate, weights)
      call find_mean(self%law, self%sign, self%shift, self%origin, value, .true., mean, open, doubt)
      doubt = abs(self%factor*(value - self%origin))*doubt
   end function effort_energy_doubt

   !> The energy of a law is its integral from zero, or from the first value where that does not exist, as of 1/s.
   pure subroutine effort_begin_energy(self, kinematics)
      class(force_element_type), intent(inout) :: self
      type(kinematics_type), intent(in) :: kinematics
      !> Part of the integral in intervals that could not be made small enough
      real(wp), parameter :: nothing = 1.0e-9_wp
      real(wp) :: value, rate, weights(2, 3), mean, open
      if (.not. self%stores) return
      call read_gauge(self%gauges(1), kinematics, value, rate, weights)
      call find_mean(self%law, self%sign, self%shift, 0.0_wp, value, .true., mean, open)
      self%origin = merge(0.0_wp, value, open <= nothing*min(abs(mean), huge(mean)))
   end subroutine effort_begin_energy

   !> All but what comes from the energy.
   pure subroutine effort_add_power(self, kinematics, sum)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
      real(wp) :: value, rate, push, weights(2, 3)
      if (.not. self%powered) return
      call self%measure(kinematics, value, rate, push, weights)
      if (self%stores) then
         sum = sum - self%damping*rate**2
      else
         sum = sum + (push + self%stiffness*value)*rate
      end if
   end subroutine effort_add_power

   !> Of all that is neither linear in s nor a law of it alone: these the step has exactly.
   pure subroutine effort_add_missed_power(self, mean, now, sum)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(inout) :: sum
      real(wp) :: value, rate, push, weights(2, 3), value_now, rate_now, push_now
      call self%measure(mean, value, rate, push, weights)
      call self%measure(now, value_now, rate_now, push_now, weights)
      if (self%potential) then
         sum = sum - self%damping*(rate_now - rate)*rate_now
      else if (self%follower) then
         sum = sum + push_now*rate_now - push*rate
      else
         sum = sum + (push_now + self%stiffness*value_now - push - self%stiffness*value)*rate_now
      end if
   end subroutine effort_add_missed_power

   !> Of the law, unless it has an energy.
   pure subroutine effort_add_missed_force(self, mean, now, part, force)
      class(force_element_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(in) :: part
      real(wp), intent(inout) :: force(:)
      real(wp) :: value, rate, push, weights(2, 3)
      integer :: m, k
      if (self%potential .or. .not. self%driven) return
      call read_gauge(self%gauges(1), mean, value, rate, weights)
      push = part*self%factor*(law_value(self, now) - law_value(self, mean))
      do m = 1, merge(1, 3, self%follower)
         k = self%gauges(1)%parts(m)
         if (k == 0) cycle
         call add_marker(mean%markers(self%gauges(1)%markers(m)), push*weights(:, m), &
            & force(self%offsets(k) + 1:self%offsets(k) + self%rates(k)))
      end do
   end subroutine effort_add_missed_force

   !> Mean of a law of one variable between two values of it: its antiderivative's difference over theirs, by Gauss's formula on
   !> intervals that are halved until both halves agree with the whole, and the law takes the same branches at both ends: a stop
   !> that begins behind the last of Gauss's points counts too. Kinks leave few intervals rough, however deep; where very
   !> many are, it is the law's own round-off that is seen, and halving ends.
   pure real(wp) function mean_law(law, sign, shift, start, end) result(mean)
      type(expression_type), intent(in) :: law
      !> Each slot is sign times the variable + shift
      real(wp), intent(in) :: sign(:), shift(:)
      real(wp), intent(in) :: start, end
      real(wp) :: open
      call find_mean(law, sign, shift, start, end, .false., mean, open)
   end function mean_law

   !> The same, and how much of it, in size, comes from the intervals that were not small enough at last. Over a long way, as that
   !> of an energy, all points of an interval may miss what comes and goes between them: its bounds do not. It is halved as long as
   !> they lie beyond the points by as much as in its parent; bounds that are only wide shrink.
   pure subroutine find_mean(law, sign, shift, start, end, is_long, mean, open, doubt)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: sign(:), shift(:)
      real(wp), intent(in) :: start, end
      !> Whether the way may be long
      logical, intent(in) :: is_long
      real(wp), intent(out) :: mean, open
      !> By how much halves and whole of such intervals differ
      real(wp), intent(out), optional :: doubt
      !> Errors relative to the largest value that count as round-off, and where very many intervals are rough; excess of bounds
      !> that counts as none; part of it that is left in a half where bounds are only wide
      real(wp), parameter :: fine = 1.0e-15_wp, coarse = 1.0e-11_wp, negligible = 1.0e-13_wp, shrinks = 0.6_wp
      !> Ends of the intervals that are rough, branches there, means over them, and the least and largest value at their points
      real(wp) :: ends(2, most_rough), means(most_rough), spans(2, most_rough)
      real(wp) :: next_ends(2, 2*most_rough), next_means(2*most_rough), next_spans(2, 2*most_rough)
      integer(long) :: branches(2, most_rough), next_branches(2, 2*most_rough), between
      real(wp) :: middle, halves(2), values(2, 2), level, share, exact, differences
      integer :: i, rough, found, depth, most
      logical :: differs, hides, bounded
      mean = 0.0_wp
      open = 0.0_wp
      level = 0.0_wp
      share = 1.0_wp
      exact = fine
      rough = 1
      between = -1
      bounded = is_long .and. law%may_bend()
      most = merge(most_rough, few_rough, is_long)
      hides = .false.
      ends(:, 1) = [start, end]
      branches(1, 1) = branch_at(law, sign, shift, start, end - start)
      branches(2, 1) = branches(1, 1)
      if (branches(1, 1) >= 0) branches(2, 1) = branch_at(law, sign, shift, end, end - start)
      call gauss_mean(law, sign, shift, ends(:, 1), means(1), spans(:, 1), level)
      do depth = 1, deepest
         found = 0
         open = 0.0_wp
         differences = 0.0_wp
         do i = 1, rough
            middle = ends(1, i) + 0.5_wp*(ends(2, i) - ends(1, i))
            call gauss_mean(law, sign, shift, [ends(1, i), middle], halves(1), values(:, 1), level)
            call gauss_mean(law, sign, shift, [middle, ends(2, i)], halves(2), values(:, 2), level)
            if (branches(1, 1) >= 0) between = branch_at(law, sign, shift, middle, end - start)
            differs = share*abs(0.5_wp*sum(halves) - means(i)) > exact*level .or. any(branches(:, i) /= between)
            if (bounded .and. .not. differs) hides = may_hide(ends(:, i), spans(:, i), middle, values, share)
            if (differs .or. hides) then
               next_ends(:, found + 1) = [ends(1, i), middle]
               next_ends(:, found + 2) = [middle, ends(2, i)]
               next_branches(:, found + 1) = [branches(1, i), between]
               next_branches(:, found + 2) = [between, branches(2, i)]
               next_means(found + 1:found + 2) = halves
               next_spans(:, found + 1:found + 2) = values
               found = found + 2
               if (differs) open = open + 0.5_wp*share*sum(abs(halves))
               differences = differences + share*abs(0.5_wp*sum(halves) - means(i))
            else
               mean = mean + 0.5_wp*share*sum(halves)
            end if
         end do
         share = 0.5_wp*share
         if (found > most .or. depth == deepest) mean = mean + share*sum(next_means(:found))
         if (present(doubt)) doubt = differences
         if (found == 0 .or. found > most) return
         if (found > few_rough) exact = coarse
         rough = found
         ends(:, :rough) = next_ends(:, :rough)
         branches(:, :rough) = next_branches(:, :rough)
         means(:rough) = next_means(:rough)
         spans(:, :rough) = next_spans(:, :rough)
      end do

   contains

      !> Whether the law may be something in an interval that its points do not show: its bounds lie beyond them, and do not
      !> shrink in a half of it.
      pure logical function may_hide(ends, span, middle, values, share) result(may)
         !> Of the interval, and the least and largest value at its points
         real(wp), intent(in) :: ends(2), span(2)
         !> The same of its halves
         real(wp), intent(in) :: middle, values(2, 2)
         !> Part of the way
         real(wp), intent(in) :: share
         real(wp) :: beyond
         beyond = excess_of(law, sign*ends(1) + shift, sign*ends(2) + shift, span)
         may = share*beyond > negligible*level
         if (may) may = max(excess_of(law, sign*ends(1) + shift, sign*middle + shift, values(:, 1)), &
            & excess_of(law, sign*middle + shift, sign*ends(2) + shift, values(:, 2))) > shrinks*beyond
      end function may_hide

   end subroutine find_mean

   !> The branches that a law of one variable takes behind a value, on the way from start to end; -1 if it has none.
   pure integer(long) function branch_at(law, sign, shift, value, way) result(branch)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: sign(:), shift(:), value, way
      type(jet_type) :: line(max_slots)
      integer :: k
      do k = 1, size(sign)
         line(k)%value = sign(k)*value + shift(k)
         line(k)%first = sign(k)*way
      end do
      branch = law%branches_along(line(:size(sign)))
   end function branch_at

   !> Gauss's formula for the mean over an interval, and the largest value so far.
   pure subroutine gauss_mean(law, sign, shift, ends, mean, span, level)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: sign(:), shift(:)
      real(wp), intent(in) :: ends(2)
      real(wp), intent(out) :: mean
      !> Least and largest value at the points
      real(wp), intent(out) :: span(2)
      real(wp), intent(inout) :: level
      real(wp) :: values(max_slots), f
      integer :: k
      mean = 0.0_wp
      span = [huge(f), -huge(f)]
      do k = 1, size(gauss)
         f = 0.5_wp*(ends(1) + ends(2)) + 0.5_wp*(ends(2) - ends(1))*gauss(k)
         values(:size(sign)) = sign*f + shift
         f = law%evaluate(values(:size(sign)))
         mean = mean + 0.5_wp*gauss_weights(k)*f
         level = max(level, abs(f))
         span = [min(span(1), f), max(span(2), f)]
      end do
   end subroutine gauss_mean

   !> By how much the bounds of a law lie beyond two values while its slots are between two places; where it may be undefined there
   !> by any number.
   pure real(wp) function excess_of(law, first, second, span) result(excess)
      type(expression_type), intent(in) :: law
      !> Slots at both places
      real(wp), intent(in) :: first(:), second(:)
      !> The lower and the higher one
      real(wp), intent(in) :: span(2)
      type(range_type) :: range
      logical :: halting(size(ieee_all)), flags(size(ieee_all))
      excess = huge(excess)
      ! Bounds may overflow where the law does not
      call ieee_get_halting_mode(ieee_all, halting)
      call ieee_get_flag(ieee_all, flags)
      call ieee_set_halting_mode(ieee_all, .false.)
      range = law_range_over(law, min(first, second), max(first, second))
      if (range%defined) excess = min(huge(excess), max(0.0_wp, span(1) - range%low, range%high - span(2)))
      call ieee_set_flag(ieee_all, flags)
      call ieee_set_halting_mode(ieee_all, halting)
   end function excess_of

end module limber_multibody_force_elements
