!> Predictor of the energy-momentum scheme. What the next step is predicted from, and the second derivative of the rates, of which
!> its local error is made. Rates are those in the axes of the frames. Floor: integrator. Source: doc/theory, eqs. (5.21), (5.31).
module limber_integrator_mean_rates
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_multibody_plane_vectors, only: turn, along
   use limber_multibody_layout, only: layout_type
   implicit none
   private
   public :: means_type, new_means, begin_means, predict, find_curvature, note_mean, largest_change

   !> Of the last two steps, the latest first
   type :: means_type
      !> Mean rates (nw, 2) and multipliers (nc, 2), times of their middles and lengths
      real(wp), allocatable :: rates(:, :), multipliers(:, :)
      real(wp) :: time(2) = 0.0_wp, step(2) = 0.0_wp
      !> Second derivatives of the rates at the step before and at the last one that was tried (nw), and whether there is one before
      real(wp), allocatable :: curvature_before(:), curvature(:)
      logical :: has_curvature = .false.
   contains
      procedure :: exchange => exchange_means
   end type means_type

contains

   !> Room.
   subroutine new_means(nw, nc, means)
      !> Numbers of rates and of multipliers
      integer, intent(in) :: nw, nc
      type(means_type), intent(inout) :: means
      allocate (means%rates(nw, 2), means%multipliers(nc, 2), means%curvature_before(nw), means%curvature(nw))
   end subroutine new_means

   !> A past that the first prediction follows from.
   subroutine begin_means(means, layout, t, h, b, slope, lambda)
      type(means_type), intent(inout) :: means
      type(layout_type), intent(in) :: layout
      !> Time, first step; rates (nw), multipliers (nc)
      real(wp), intent(in) :: t, h
      real(wp), contiguous, intent(in) :: b(:), lambda(:)
      !> Accelerations in the axes of the frames, then the derivatives of b (nw)
      real(wp), contiguous, intent(inout) :: slope(:)
      integer :: i, at
      do i = 1, size(layout%q)
         if (.not. layout%framed(i)) cycle
         at = layout%w(i)
         slope(at:at + 1) = slope(at:at + 1) - b(at + 2)*turn(b(at:at + 1))
      end do
      means%time = [t, t - h]
      means%rates(:, 1) = b
      means%rates(:, 2) = b - h*slope
      means%multipliers = spread(lambda, 2, 2)
      means%curvature = 0.0_wp
      means%curvature_before = 0.0_wp
      means%has_curvature = .false.
   end subroutine begin_means

   !> Increments and multipliers from the mean rates of the last two steps; or from the last step, with deflections that rest,
   !> which is the better guess where vibrations are not resolved.
   subroutine predict(means, layout, t, h, q, smooth, y, lambda)
      type(means_type), intent(in) :: means
      type(layout_type), intent(in) :: layout
      !> Time at the start of the step, its length; coordinates (nq)
      real(wp), intent(in) :: t, h
      real(wp), contiguous, intent(in) :: q(:)
      !> Whether from two steps
      logical, intent(in) :: smooth
      !> Increments (nw), multipliers (nc)
      real(wp), contiguous, intent(inout) :: y(:), lambda(:)
      real(wp) :: part, alpha, v(2)
      integer :: i, at
      part = 0.0_wp
      if (smooth) part = (t + 0.5_wp*h - means%time(1))/(means%time(1) - means%time(2))
      y = h*(means%rates(:, 1) + part*(means%rates(:, 1) - means%rates(:, 2)))
      lambda = means%multipliers(:, 1) + part*(means%multipliers(:, 1) - means%multipliers(:, 2))
      do i = 1, size(layout%q)
         if (.not. layout%framed(i)) cycle
         at = layout%w(i)
         if (.not. smooth) y(at + 3:at + 2 + layout%n(i)) = 0.0_wp
         alpha = y(at + 2)
         v = along(y(at:at + 1), q(layout%q(i) + 2:layout%q(i) + 3))
         v = (v + 0.5_wp*alpha*turn(v))/(1 + 0.25_wp*alpha**2)
         y(at:at + 1) = v
      end do
   end subroutine predict

   !> Second derivative of the rates, from those of the step that is tried and of the last two.
   subroutine find_curvature(means, t, h, b, new_b, since, change)
      type(means_type), intent(inout) :: means
      !> Time at the start of the step, its length; rates at its start and end (nw)
      real(wp), intent(in) :: t, h
      real(wp), contiguous, intent(in) :: b(:), new_b(:)
      !> Time from the middle of the last step to that of this one
      real(wp), intent(out) :: since
      !> Scratch (nw)
      real(wp), contiguous, intent(inout) :: change(:)
      real(wp) :: last, both, widths
      since = t + 0.5_wp*h - means%time(1)
      last = means%time(1) - means%time(2)
      both = since + last
      widths = ((h**2 - means%step(1)**2)/since - (means%step(1)**2 - means%step(2)**2)/last)/both
      change = 0.5_wp*(b + new_b) - means%rates(:, 1)
      means%curvature = (change/since - (means%rates(:, 1) - means%rates(:, 2))/last)/both/(0.5_wp + 0.125_wp*widths)
   end subroutine find_curvature

   !> Takes in a step that is accepted.
   subroutine note_mean(means, t, h, b, new_b, lambda, has_curvature)
      type(means_type), intent(inout) :: means
      !> Time at its start, its length; rates at its start and end (nw), multipliers (nc)
      real(wp), intent(in) :: t, h
      real(wp), contiguous, intent(in) :: b(:), new_b(:), lambda(:)
      !> Whether its curvature is one
      logical, intent(in) :: has_curvature
      means%rates(:, 2) = means%rates(:, 1)
      means%rates(:, 1) = 0.5_wp*(b + new_b)
      means%multipliers(:, 2) = means%multipliers(:, 1)
      means%multipliers(:, 1) = lambda
      means%time = [t + 0.5_wp*h, means%time(1)]
      means%step = [h, means%step(1)]
      means%curvature_before = means%curvature
      means%has_curvature = has_curvature
   end subroutine note_mean

   !> Largest change of the rates of frames and points, in units of scales.
   pure real(wp) function largest_change(layout, before, after, scales) result(largest)
      type(layout_type), intent(in) :: layout
      !> (nw)
      real(wp), intent(in) :: before(:), after(:), scales(:)
      integer :: i, from, to
      largest = 0.0_wp
      do i = 1, size(layout%w)
         from = layout%w(i)
         to = merge(from + 2, from + 1, layout%framed(i))
         largest = max(largest, maxval(abs(after(from:to) - before(from:to))/scales(from:to)))
      end do
   end function largest_change

   !> Saves or restores its memory.
   subroutine exchange_means(self, snapshot)
      class(means_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('mean', self%rates)
      call snapshot%keep('mean_lambda', self%multipliers)
      call snapshot%exchange('mean_time', self%time)
      call snapshot%exchange('mean_step', self%step)
      call snapshot%keep('curvature_before', self%curvature_before)
      call snapshot%keep('curvature', self%curvature)
      call snapshot%exchange('has_curvature', self%has_curvature)
   end subroutine exchange_means

end module limber_integrator_mean_rates
