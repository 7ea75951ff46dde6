!> Monitor of the foreshortening of beams with modes. The inertia of that, its axial forces, and the displacements along the beam
!> that channels ask for. Floor: monitor. Source: doc/theory, eqs. (7.20), (7.21), (7.24), (7.47).
module limber_monitor_beam_shortening
   use limber_base_kinds, only: wp
   use limber_monitor_drawn_channels, only: drawn_channels_type
   use limber_monitor_indicators, only: body_indicators_type, raise_peak, peak_recoil, peak_drawn, sum_shortening
   use limber_beam_monitored_sections, only: monitored_sections_type
   use limber_model_model, only: model_type, body_type
   implicit none
   private
   public :: add_shortening, observe_recoil, observe_drawn

contains

   !> Energy of the shortening that a vibration makes: what hangs on the beam, and its own mass, move along it by half of the
   !> squared slopes, eq. (7.21).
   pure subroutine add_shortening(self, stations, body, rate)
      type(body_indicators_type), intent(inout) :: self
      type(monitored_sections_type), intent(in) :: stations
      type(body_type), intent(in) :: body
      !> Of the coordinates (n)
      real(wp), intent(in) :: rate(:)
      real(wp) :: fixed, part, energy
      integer :: s, k, b
      b = stations%bending
      ! Scratch: the speed along the beam at each station
      fixed = 0.0_wp
      do s = 1, stations%count
         part = 0.0_wp
         do k = 1, b
            part = part + stations%slope(k, s)*rate(k)
         end do
         part = 0.5_wp*stations%weight(s)*part*self%slope(s)
         self%force(s) = fixed + part
         fixed = self%force(s) + part
      end do
      fixed = 0.0_wp
      if (self%anchor > 0) fixed = value_at(self, stations, stations%place(self%anchor))
      energy = 0.0_wp
      do s = 1, stations%count
         energy = energy + stations%weight(s)*body%beam%rho_a*(self%force(s) - fixed)**2
      end do
      do k = 1, size(self%carried)
         energy = energy + self%carried(k)*(value_at(self, stations, stations%place(k)) - fixed)**2
      end do
      self%total(sum_shortening) = self%total(sum_shortening) + energy
   end subroutine add_shortening

   !> Axial force that the inertia of the shortening makes, the largest one, and its work on the bending, eq. (7.20). A K_G beam
   !> does not have it, and it is all that ends the growth of a bending which an axial vibration feeds.
   pure subroutine observe_recoil(self, stations, body, t, rate, acceleration)
      type(body_indicators_type), intent(inout) :: self
      type(monitored_sections_type), intent(in) :: stations
      type(body_type), intent(in) :: body
      !> Time; rates and accelerations of the coordinates (n)
      real(wp), intent(in) :: t, rate(:), acceleration(:)
      real(wp) :: part, fixed, force, work, faster, turned
      integer :: s, k, at
      self%drawing_in%force = 0.0_wp
      ! Scratch: how much the stations are drawn in, a unit of time squared
      fixed = 0.0_wp
      do s = 1, stations%count
         turned = 0.0_wp
         faster = 0.0_wp
         do k = 1, stations%bending
            turned = turned + stations%slope(k, s)*rate(k)
            faster = faster + stations%slope(k, s)*acceleration(k)
         end do
         part = 0.5_wp*stations%weight(s)*(turned**2 + self%slope(s)*faster)
         self%force(s) = fixed + part
         fixed = self%force(s) + part
      end do
      fixed = 0.0_wp
      if (self%anchor > 0) fixed = self%force(station_at(stations, self%anchor))
      force = 0.0_wp
      work = 0.0_wp
      do s = stations%count, 1, -1
         do k = 1, stations%places
            at = station_at(stations, k)
            if (at == s .and. k /= self%anchor) force = force + self%carried(k)*(self%force(s) - fixed)
         end do
         part = 0.5_wp*stations%weight(s)*body%beam%rho_a*(self%force(s) - fixed)
         force = force + part
         work = work + stations%weight(s)*force*self%slope(s)**2
         self%drawing_in%force = max(self%drawing_in%force, abs(force))
         force = force + part
         if (self%anchor == 0) cycle
         ! The ground takes what is beyond: from there on the other side counts
         if (station_at(stations, self%anchor) == s) force = -drawn_before(self, stations, body, s, fixed)
      end do
      call raise_peak(self, peak_recoil, abs(work), t)
   end subroutine observe_recoil

   !> Force that draws in what lies before a station.
   pure real(wp) function drawn_before(self, stations, body, station, fixed) result(force)
      type(body_indicators_type), intent(in) :: self
      type(monitored_sections_type), intent(in) :: stations
      type(body_type), intent(in) :: body
      integer, intent(in) :: station
      real(wp), intent(in) :: fixed
      integer :: s, k
      force = 0.0_wp
      do s = 1, station - 1
         force = force + stations%weight(s)*body%beam%rho_a*(self%force(s) - fixed)
      end do
      do k = 1, stations%places
         if (station_at(stations, k) < station) force = force + self%carried(k)*(self%force(station_at(stations, k)) - fixed)
      end do
   end function drawn_before

   !> The station next to a place.
   pure integer function station_at(stations, place)
      type(monitored_sections_type), intent(in) :: stations
      integer, intent(in) :: place
      station_at = minloc(abs(stations%x - stations%place(place)), dim=1)
   end function station_at

   !> How far bending draws in the points that are asked for and the mass, with rates and accelerations, eq. (7.24).
   pure subroutine observe_drawn(self, stations, model, t, rate, acceleration, channels)
      type(body_indicators_type), intent(inout) :: self
      type(monitored_sections_type), intent(in) :: stations
      type(model_type), intent(in) :: model
      !> Time; rates and accelerations of the coordinates (n)
      real(wp), intent(in) :: t, rate(:), acceleration(:)
      type(drawn_channels_type), intent(inout) :: channels
      real(wp) :: fixed, part, turned, faster, total
      integer :: s, k, order
      if (.not. allocated(channels%field)) return
      if (.not. channels%bends(self%body)) return
      associate (body => model%bodies(self%body))
         do order = 0, 2
            ! Scratch: how far the stations are drawn in from the start
            total = 0.0_wp
            do s = 1, stations%count
               turned = 0.0_wp
               faster = 0.0_wp
               do k = 1, stations%bending
                  turned = turned + stations%slope(k, s)*rate(k)
                  faster = faster + stations%slope(k, s)*acceleration(k)
               end do
               select case (order)
               case (0); part = 0.5_wp*self%slope(s)**2
               case (1); part = self%slope(s)*turned
               case default; part = turned**2 + self%slope(s)*faster
               end select
               part = 0.5_wp*stations%weight(s)*part
               self%force(s) = total + part
               total = self%force(s) + part
            end do
            if (order == 0) call raise_peak(self, peak_drawn, total/self%length, t)
            ! Ends that cannot approach each other stretch it
            if (self%held) self%force = self%force - total*stations%x/body%beam%length
            fixed = value_at(self, stations, body%choice%origin)
            ! The frame of a free beam is its mean motion
            if (.not. (body%choice%support%w_start .or. body%choice%support%w_end)) &
               & fixed = dot_product(stations%weight, self%force)/sum(stations%weight)
            do k = 1, size(channels%points)
               associate (point => model%points(channels%points(k)))
                  if (point%body == self%body) channels%field(1, order, k) = fixed - value_at(self, stations, point%along)
               end associate
            end do
            channels%inertia(1, order, self%body) = body%beam%rho_a*(sum(stations%weight)*fixed &
               & - dot_product(stations%weight, self%force))
         end do
      end associate
   end subroutine observe_drawn

   !> What the scratch of the stations is at a place.
   pure real(wp) function value_at(self, stations, x) result(value)
      type(body_indicators_type), intent(in) :: self
      type(monitored_sections_type), intent(in) :: stations
      !> Coordinate along the beam
      real(wp), intent(in) :: x
      integer :: j
      do j = 2, stations%count - 1
         if (stations%x(j) > x) exit
      end do
      value = self%force(j) + (self%force(j) - self%force(j - 1))*(x - stations%x(j))/(stations%x(j) - stations%x(j - 1))
   end function value_at

end module limber_monitor_beam_shortening
