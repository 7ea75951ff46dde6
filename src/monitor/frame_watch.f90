!> Indicators of frames at a state. Axial forces in all members against those under which the frame, as joints hold it on the
!> ground, would buckle; what its model lacks of them; loads that its coordinates cannot carry. Floor: monitor. Source: doc/theory,
!> eqs. (7.36)-(7.46).
module limber_monitor_frame_watch
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev
   use limber_monitor_drawing_in, only: start_drawing_in, find_drawing_in, show_drawing_in
   use limber_monitor_indicators, only: indicators_type, body_indicators_type, raise_peak, peak_compression, peak_tension, &
      & peak_left_out, peak_axial, peak_axial_grown, peak_layer, &
      & peak_quartic, peak_quartic_grown, peak_membrane, peak_membrane_force, peak_pull, &
      & peak_own_pull, peak_strained, peak_recoil, peak_drawn, sum_shortening, add_geometric, add_vibration, raise_recoil_force
   use limber_monitor_membrane, only: start_membrane, find_membrane
   use limber_monitor_body_surveys, only: body_survey_type, take_amplitudes, is_base
   use limber_beam_elastic_forces, only: elastic_force
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_mesh_forces, only: axial_work
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: observe_frames

   !> Least part of the stiffness that a compression leaves, of which an error is a part
   real(wp), parameter :: least = 0.02_wp

contains

   !> All frames. Kinematics are placed and moved in the state; Jacobians and multipliers are its own.
   subroutine observe_frames(self, system, work, t, q, v, a)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Time; coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: t, q(:), v(:), a(:)
      integer :: i, first, last
      if (size(self%surveys%bodies) == 0) return
      call take_amplitudes(self%surveys, system, work, q, v, a)
      do i = 1, size(self%surveys%bodies)
         associate (survey => self%surveys%bodies(i), body => self%surveys%bodies(i)%body)
            if (self%surveys%of(body) == 0) cycle
            first = system%layout%q(body)
            last = first + 3 + system%layout%n(body)
            if (.not. allocated(self%bodies(self%of(body))%strained)) call hold(system, work, survey, &
               & self%bodies(self%of(body)))
            if (.not. self%bodies(self%of(body))%membrane%made) call start_membrane(self%bodies(self%of(body))%membrane, system, &
               & work, self%surveys, survey, q)
            call observe_frame(self%bodies(self%of(body)), survey, system%model%bodies(body)%reduced, t, q(first + 4:last))
            call observe_drawing_in(self%bodies(self%of(body)), survey, system%model%bodies(body)%reduced, t, &
               & q(first + 4:last), v(first + 4:last), a(first + 4:last))
            if (allocated(self%bodies(self%of(body))%drawing_in%slots)) call show_drawing_in( &
               & self%bodies(self%of(body))%drawing_in, body, self%drawn)
         end associate
      end do
   end subroutine observe_frames

   !> The motions that strain a frame as its joints with the ground, or with rigid bodies of known motion, hold it; without any,
   !> those of its coordinates alone.
   subroutine hold(system, work, own, body)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(body_survey_type), intent(in) :: own
      type(body_indicators_type), intent(inout) :: body
      real(wp), allocatable :: rows(:, :), gram(:, :), value(:), room(:), stiffness(:, :), free(:, :)
      real(wp) :: scale(3 + size(own%survey%chosen))
      integer :: m, count, i, side, row, info, k, free_count
      m = size(own%survey%chosen)
      scale = 1.0_wp
      associate (reduced => system%model%bodies(own%body)%reduced)
         scale(1:3) = [1/sqrt(reduced%mass), 1/sqrt(reduced%mass), 1/sqrt(max(reduced%i0, tiny(1.0_wp)))]
      end associate
      allocate (rows(system%nc, 3 + m))
      count = 0
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               if (item%bodies(side) /= own%body .or. .not. is_base(system, item%bodies(3 - side))) cycle
               do row = 1, item%rows
                  count = count + 1
                  rows(count, :3) = work%jacobians(side, i)%z(row, 1:3)*scale(1:3)
                  rows(count, 4:) = work%jacobians(side, i)%eta(row, own%survey%chosen)
                  rows(count, :) = rows(count, :)/max(norm2(rows(count, :)), tiny(1.0_wp))
               end do
            end do
         end associate
      end do
      if (count == 0) then
         allocate (free(3 + m, m))
         free = 0.0_wp
         do k = 1, m
            free(3 + k, k) = 1.0_wp
         end do
      else
         allocate (gram(3 + m, 3 + m), value(3 + m), room(8*(3 + m)))
         gram = matmul(transpose(rows(:count, :)), rows(:count, :))
         call dsyev('V', 'L', 3 + m, gram, 3 + m, value, room, size(room), info)
         free_count = 0
         do k = 1, 3 + m
            if (value(k) < 1.0e-10_wp) free_count = k
         end do
         if (info /= 0) free_count = 0
         allocate (free, source=gram(:, :free_count))
         deallocate (value, room)
      end if
      k = size(free, 2)
      allocate (stiffness(k, k), value(k), room(max(1, 8*k)))
      do i = 1, k
         stiffness(:, i) = matmul(own%survey%omega2*free(4:, i), free(4:, :))
      end do
      info = 0
      if (k > 0) call dsyev('V', 'L', k, stiffness, k, value, room, size(room), info)
      count = 0
      if (k > 0 .and. info == 0) count = size(pack(value, value > max(1.0e-12_wp*value(k), 1.0e-9_wp*minval(own%survey%omega2))))
      allocate (body%strained(0:m, count))
      do i = 1, count
         associate (vector => matmul(free, stiffness(:, k - count + i)))
            body%strained(0, i) = vector(3)*scale(3)/sqrt(value(k - count + i))
            body%strained(1:, i) = vector(4:)/sqrt(value(k - count + i))
         end associate
      end do
      allocate (body%loaded(count, count), body%value(count), body%room(max(1, 8*count)))
   end subroutine hold

   !> The peaks of one frame.
   subroutine observe_frame(self, own, reduced, t, eta)
      type(body_indicators_type), intent(inout) :: self
      type(body_survey_type), intent(in) :: own
      type(reduced_type), intent(in) :: reduced
      !> Time; coordinates (n)
      real(wp), intent(in) :: t, eta(:)
      real(wp) :: work, elastic, lack, quick, left_out, part, weakest, quartic, strained, layer, looked_at(size(eta))
      integer :: i, k, m, info
      m = size(own%survey%chosen)
      call axial_work(own%survey, own%amplitude, self%slope_work)
      ! By how much the joints let the frame turn as it is strained
      part = 0.0_wp
      do i = 1, size(self%value)
         do k = 1, m
            part = part + self%strained(0, i)*self%strained(k, i)*own%survey%omega2(k)*eta(own%survey%chosen(k))
         end do
      end do
      call look_at_members(own, part, eta, layer, quartic, strained)
      call raise_peak(self, peak_layer, layer/self%layer, t)
      call raise_peak(self, peak_quartic, quartic, t)
      elastic = 0.0_wp
      do k = 1, m
         do i = 1, m
            elastic = elastic + eta(own%survey%chosen(i))*own%survey%bending(i, k)*eta(own%survey%chosen(k))
         end do
      end do
      work = 0.0_wp
      self%elastic = 0.0_wp
      if (reduced%geometric) then
         ! Of the coordinates that are looked at, as the work is
         looked_at = 0.0_wp
         looked_at(own%survey%chosen) = eta(own%survey%chosen)
         call elastic_force(reduced, looked_at, self%elastic, self%s)
         self%elastic = self%elastic - reduced%omega2*looked_at
      end if
      self%lacking(0) = 0.0_wp
      do i = 1, m
         part = 0.0_wp
         do k = 1, m
            part = part + self%slope_work(i, k)*eta(own%survey%chosen(k))
         end do
         work = work + part*eta(own%survey%chosen(i))
         self%lacking(i) = part - self%elastic(own%survey%chosen(i))
      end do
      call load_motions(self)
      if (size(self%value) == 0) return
      call dsyev('V', 'L', size(self%value), self%loaded, size(self%value), self%value, self%room, size(self%room), info)
      if (info /= 0) return
      weakest = max(least, 1 + self%value(1))
      lack = 0.0_wp
      quick = 0.0_wp
      do i = 1, size(self%value)
         part = 0.0_wp
         do k = 1, size(self%value)
            part = part + self%loaded(k, i)*dot_product(self%strained(:, k), self%lacking)
         end do
         part = part**2
         quick = quick + part/(1 + max(self%value(i), 0.0_wp))
         lack = lack + merge(part/max(least, 1 + self%value(i))**2, part/(1 + max(self%value(i), 0.0_wp)), self%value(i) < 0.0_wp)
      end do
      left_out = left_out_work(own)/min(1.0_wp, weakest)
      call raise_peak(self, peak_quartic_grown, quartic/min(1.0_wp, weakest), t)
      call raise_peak(self, peak_strained, strained/min(1.0_wp, weakest), t)
      call raise_peak(self, peak_compression, -self%value(1), t)
      call raise_peak(self, peak_tension, self%value(size(self%value)), t)
      call add_geometric(self, work, elastic, t)
      call raise_peak(self, peak_axial, quick, t)
      call raise_peak(self, peak_axial_grown, lack, t)
      call raise_peak(self, peak_left_out, left_out, t)
      if (self%membrane%redundant) call observe_membrane(self, own, t, eta, elastic)
   end subroutine observe_frame

   !> The inertia of the shortening that the model leaves out, eqs. (7.44)-(7.46).
   subroutine observe_drawing_in(self, own, reduced, t, eta, rate, acceleration)
      type(body_indicators_type), intent(inout) :: self
      type(body_survey_type), intent(in) :: own
      type(reduced_type), intent(in) :: reduced
      !> Time; coordinates, their rates and accelerations (n)
      real(wp), intent(in) :: t, eta(:), rate(:), acceleration(:)
      if (.not. self%drawing_in%made) call start_drawing_in(self%drawing_in, self%membrane, own%survey, self%carried)
      call find_drawing_in(self%drawing_in, own%survey, eta, rate, acceleration)
      call add_vibration(self, reduced%omega2, t, eta, rate, acceleration)
      self%total(sum_shortening) = self%total(sum_shortening) + self%drawing_in%energy
      call raise_peak(self, peak_recoil, abs(self%drawing_in%work), t)
      call raise_peak(self, peak_drawn, maxval(abs(self%drawing_in%short))/self%length, t)
      call observe_pull(self, own, t)
      call raise_recoil_force(self, self%drawing_in%force, t)
   end subroutine observe_drawing_in

   !> What the axial force that the shortening makes changes: the deflection, eq. (7.43), and forces. Motions and eigenvalues under
   !> the axial forces of the loads are those of the state.
   subroutine observe_membrane(self, own, t, eta, elastic)
      type(body_indicators_type), intent(inout) :: self
      type(body_survey_type), intent(in) :: own
      !> Time; coordinates (n); twice the energy of bending
      real(wp), intent(in) :: t, eta(:), elastic
      real(wp) :: part, change, stiffer, kept
      integer :: i, k
      if (.not. elastic > 0.0_wp) return
      call find_membrane(self%membrane, own%survey, eta)
      change = 0.0_wp
      do i = 1, size(self%value)
         part = 0.0_wp
         do k = 1, size(self%value)
            part = part + self%loaded(k, i)*dot_product(self%strained(:, k), self%membrane%push)
         end do
         change = change + (part/(1 + max(self%value(i), 0.0_wp)))**2
      end do
      stiffer = sqrt(change/elastic)
      kept = 1.0_wp
      do i = 1, 30
         kept = kept - (kept + stiffer*kept**3 - 1)/(1 + 3*stiffer*kept**2)
      end do
      call raise_peak(self, peak_membrane, 1 - kept, t)
      call raise_peak(self, peak_membrane_force, kept**2*maxval(abs(self%membrane%force)), t)
   end subroutine observe_membrane

   !> Largest axial force, and largest one or load, so far.
   pure subroutine observe_pull(self, own, t)
      type(body_indicators_type), intent(inout) :: self
      type(body_survey_type), intent(in) :: own
      real(wp), intent(in) :: t
      integer :: i
      if (.not. self%shows_axial) return
      do i = 1, size(own%survey%pull, 1)
         call raise_peak(self, peak_own_pull, abs(dot_product(own%survey%pull(i, :), own%amplitude)), t)
      end do
      do i = size(own%amplitude) - 3*own%survey%places + 1, size(own%amplitude), 3
         call raise_peak(self, peak_pull, norm2(own%amplitude(i:i + 1)), t)
      end do
      call raise_peak(self, peak_pull, self%peak(peak_own_pull), self%time(peak_own_pull))
   end subroutine observe_pull

   !> Members by themselves: the length of one over that on which its bending dies out, sqrt(E I/N), where it is pulled most,
   !> eq. (7.19); and what the force that buckles them grows by with the slopes and with the strain, eq. (7.48).
   pure subroutine look_at_members(own, rotation, eta, layer, quartic, strained)
      type(body_survey_type), intent(in) :: own
      !> Rotation of the frame that goes with its coordinates, and these (n)
      real(wp), intent(in) :: rotation, eta(:)
      real(wp), intent(out) :: layer, quartic, strained
      real(wp) :: pull, slope(2)
      integer :: e, i
      layer = 0.0_wp
      quartic = 0.0_wp
      strained = 0.0_wp
      associate (mesh => own%survey%mesh, shape => own%survey%shape)
         do e = 1, size(mesh%member)
            pull = 0.0_wp
            do i = 1, size(own%amplitude)
               pull = pull + own%amplitude(i)*own%survey%pull(e, i)
            end do
            if (pull > 0.0_wp) then
               associate (first => mesh%first(mesh%member(e)), last => mesh%first(mesh%member(e) + 1) - 1)
                  layer = max(layer, sum(mesh%length(first:last))*sqrt(pull/mesh%ei(e)))
               end associate
            else
               slope = rotation
               do i = 1, size(eta)
                  slope = slope + shape(3, mesh%ends(:, e), i)*eta(i)
               end do
               quartic = quartic - pull*mesh%length(e)*sum(slope**4)/12
               strained = strained + pull**2/mesh%ea(e)*mesh%length(e)*(slope(1)**2 + slope(1)*slope(2) + slope(2)**2)/3
            end if
         end do
      end associate
   end subroutine look_at_members

   !> Work of the axial forces on the motions that strain the frame.
   pure subroutine load_motions(self)
      type(body_indicators_type), intent(inout) :: self
      real(wp) :: part
      integer :: i, j, k
      do j = 1, size(self%value)
         do i = 1, size(self%value)
            part = 0.0_wp
            do k = 0, ubound(self%slope_work, 2)
               part = part + dot_product(self%strained(:, i), self%slope_work(:, k))*self%strained(k, j)
            end do
            self%loaded(i, j) = part
         end do
      end do
   end subroutine load_motions

   !> Twice the energy of what the coordinates cannot carry of the loads, eq. (7.38).
   pure real(wp) function left_out_work(own) result(energy)
      type(body_survey_type), intent(in) :: own
      integer :: i, j, n, from
      n = size(own%survey%left_out, 1)
      from = size(own%amplitude) - n
      energy = 0.0_wp
      do j = 1, n
         do i = 1, n
            energy = energy + own%survey%left_out(i, j)*own%amplitude(at(i))*own%amplitude(at(j))
         end do
      end do

   contains

      !> Place of an acceleration or a load among the amplitudes.
      pure integer function at(i)
         integer, intent(in) :: i
         at = i
         if (i > 3) at = from + i
      end function at

   end function left_out_work

end module limber_monitor_frame_watch
