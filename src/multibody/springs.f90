!> Springs and dampers between two points. A force element along a distance, without a law, in closed form for speed. Floor:
!> multibody. Source: doc/theory, eqs. (3.31), (3.34), (5.27).
module limber_multibody_springs
   use limber_base_kinds, only: wp
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_load, only: load_type
   use limber_multibody_markers, only: add_marker, marker_stiffness, marker_column, drift_column
   implicit none
   private
   public :: point_spring_type

   !> A spring and a damper between two markers, g = P2 - P1 apart:
   !>
   !>    tension k (l - l0) + c l',      l = sqrt(g.g + s^2)
   !>
   !> along g/l. The softening length s is far below what can be seen; it keeps all derivatives finite where the points meet. There
   !> the damper resists the velocity, with c (s/l)^2 g', as it does on both sides of a passage.
   type, extends(load_type) :: point_spring_type
      !> Indices of the two markers
      integer :: markers(2) = 0
      !> Stiffness k [force/length], free length l0 [length], damping c [force time/length]
      real(wp) :: stiffness = 0.0_wp, free_length = 0.0_wp, damping = 0.0_wp
      !> [length]
      real(wp) :: softening = 0.0_wp
   contains
      procedure :: add_force => spring_add_force
      procedure :: add_tangent => spring_add_tangent
      procedure :: add_elasticity => spring_add_elasticity
      procedure :: add_energy => spring_add_energy
      procedure :: add_power => spring_add_power
      procedure :: add_missed_power => spring_add_missed_power
      procedure :: state_along => spring_state
      procedure :: tension => spring_tension
      procedure :: stretch => spring_stretch
   end type point_spring_type

contains

   pure subroutine spring_add_force(self, kinematics, force)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: force(:)
      real(wp) :: pull(2), gap(2), rate(2), length
      call read_gap(self, kinematics, gap, rate, length)
      pull = spring_tension(self, kinematics)/length*gap + self%damping*(self%softening/length)**2*rate
      call add_marker(kinematics%markers(self%markers(1)), pull, force(:self%rates(1)))
      call add_marker(kinematics%markers(self%markers(2)), -pull, force(self%rates(1) + 1:))
   end subroutine spring_add_force

   !> With n the pull on the first point, G = dg/dx and H = dg'/dx: G^T (n_g G + n_g' H) and what the turning of G makes;
   !> the damping is G^T n_g' G.
   pure subroutine spring_add_tangent(self, kinematics, stiffness, damping)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
      real(wp) :: by_gap(2, 2), by_rate(2, 2), pull(2), column(2), drift(2), change(2), push(2)
      integer :: i, j, first
      first = self%rates(1)
      call pull_derivatives(self, kinematics, pull, by_gap, by_rate)
      do j = 1, sum(self%rates)
         column = gap_column(self, kinematics, j)
         drift = gap_drift(self, kinematics, j)
         change = by_gap(:, 1)*column(1) + by_gap(:, 2)*column(2) + by_rate(:, 1)*drift(1) + by_rate(:, 2)*drift(2)
         push = by_rate(:, 1)*column(1) + by_rate(:, 2)*column(2)
         do i = 1, sum(self%rates)
            column = gap_column(self, kinematics, i)
            stiffness(i, j) = stiffness(i, j) + dot_product(column, change)
            damping(i, j) = damping(i, j) + dot_product(column, push)
         end do
      end do
      call marker_stiffness(kinematics, self%markers(1), -pull, stiffness(:first, :first))
      call marker_stiffness(kinematics, self%markers(2), pull, stiffness(first + 1:, first + 1:))
   end subroutine spring_add_tangent

   !> Along the spring, and across one without a free length, whose stiffness is the same in all directions.
   pure subroutine spring_add_elasticity(self, kinematics, stiffness)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: stiffness(:, :)
      real(wp) :: gap(2), rate(2), length, column(2)
      integer :: i, j
      call read_gap(self, kinematics, gap, rate, length)
      do j = 1, sum(self%rates)
         column = self%stiffness*gap_column(self, kinematics, j)
         if (self%free_length > 0.0_wp) column = dot_product(gap, column)/length*gap/length
         do i = 1, sum(self%rates)
            stiffness(i, j) = stiffness(i, j) + dot_product(gap_column(self, kinematics, i), column)
         end do
      end do
   end subroutine spring_add_elasticity

   pure subroutine spring_add_energy(self, kinematics, sum)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
      real(wp) :: gap(2), rate(2), length
      call read_gap(self, kinematics, gap, rate, length)
      sum = sum + 0.5_wp*self%stiffness*(length - self%free_length)**2
   end subroutine spring_add_energy

   !> What the damper takes.
   pure subroutine spring_add_power(self, kinematics, sum)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
      real(wp) :: gap(2), rate(2), length
      call read_gap(self, kinematics, gap, rate, length)
      sum = sum - self%damping*((dot_product(gap, rate)/length)**2 + (self%softening/length)**2*dot_product(rate, rate))
   end subroutine spring_add_power

   !> Of the damper: what the length changes by in the step is what its rate of the mean says.
   pure subroutine spring_add_missed_power(self, mean, now, sum)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(inout) :: sum
      real(wp) :: elongation, rate, rate_now
      call self%stretch(mean, elongation, rate)
      call self%stretch(now, elongation, rate_now)
      sum = sum - self%damping*(rate_now - rate)*rate_now
   end subroutine spring_add_missed_power

   !> Tension of spring and damper; kinematics are placed and moved.
   pure real(wp) function spring_tension(self, kinematics) result(tension)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: gap(2), rate(2), length
      call read_gap(self, kinematics, gap, rate, length)
      tension = self%stiffness*(length - self%free_length) + self%damping*dot_product(gap, rate)/length
   end function spring_tension

   !> Elongation, its rate and minus the tension.
   pure subroutine spring_state(self, kinematics, value, rate, push)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: value, rate, push
      call spring_stretch(self, kinematics, value, rate)
      push = -spring_tension(self, kinematics)
   end subroutine spring_state

   !> Elongation and its rate.
   pure subroutine spring_stretch(self, kinematics, elongation, rate)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: elongation, rate
      real(wp) :: gap(2), gap_rate(2), length
      call read_gap(self, kinematics, gap, gap_rate, length)
      elongation = length - self%free_length
      rate = dot_product(gap, gap_rate)/length
   end subroutine spring_stretch

   !> Gap, its rate and the softened length. Over a step the length is the mean of those at both ends, with which the pull along
   !> the mean gap is the discrete gradient of the energy: doc/theory, eq. (5.27).
   pure subroutine read_gap(self, kinematics, gap, rate, length)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: gap(2), rate(2), length
      associate (a => kinematics%markers(self%markers(1)), b => kinematics%markers(self%markers(2)))
         gap = b%position - a%position
         rate = b%velocity - a%velocity
      end associate
      if (kinematics%span > 0.0_wp) then
         length = 0.5_wp*(softened(self, gap + 0.5_wp*kinematics%span*rate) + softened(self, gap - 0.5_wp*kinematics%span*rate))
      else
         length = softened(self, gap)
      end if
   end subroutine read_gap

   !> Softened length of a gap.
   pure real(wp) function softened(self, gap) result(length)
      class(point_spring_type), intent(in) :: self
      real(wp), intent(in) :: gap(2)
      length = sqrt(dot_product(gap, gap) + self%softening**2)
   end function softened

   !> The pull n = (k (1 - l0/l) + c g.g'/l^2) g + c (s/l)^2 g' and its derivatives by g and by g'.
   pure subroutine pull_derivatives(self, kinematics, pull, by_gap, by_rate)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: pull(2), by_gap(2, 2), by_rate(2, 2)
      real(wp) :: gap(2), rate(2), length, along, drag, factor, core
      integer :: i, j
      call read_gap(self, kinematics, gap, rate, length)
      drag = self%damping/length**2
      along = dot_product(gap, rate)
      factor = self%stiffness*(1 - self%free_length/length) + drag*along
      core = self%damping*(self%softening/length)**2
      pull = factor*gap + core*rate
      do j = 1, 2
         do i = 1, 2
            by_rate(i, j) = drag*gap(i)*gap(j)
            by_gap(i, j) = (self%stiffness*self%free_length/length - 2*drag*along)*gap(i)/length*gap(j)/length &
               & + drag*gap(i)*rate(j) - 2*core*rate(i)*gap(j)/length**2
         end do
         by_gap(j, j) = by_gap(j, j) + factor
         by_rate(j, j) = by_rate(j, j) + core
      end do
   end subroutine pull_derivatives

   !> Derivative of the gap by one of the coordinates of both bodies.
   pure function gap_column(self, kinematics, j) result(column)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      integer, intent(in) :: j
      real(wp) :: column(2)
      if (j <= self%rates(1)) then
         column = -marker_column(kinematics%markers(self%markers(1)), j)
      else
         column = marker_column(kinematics%markers(self%markers(2)), j - self%rates(1))
      end if
   end function gap_column

   !> Derivative of the gap's rate by one of them.
   pure function gap_drift(self, kinematics, j) result(column)
      class(point_spring_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      integer, intent(in) :: j
      real(wp) :: column(2)
      if (j <= self%rates(1)) then
         column = -drift_column(kinematics, self%markers(1), j)
      else
         column = drift_column(kinematics, self%markers(2), j - self%rates(1))
      end if
   end function gap_drift

end module limber_multibody_springs
